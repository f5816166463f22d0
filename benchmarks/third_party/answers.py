"""Which names of dnanalyze's catalogue are right for what a case hides, and why.

A kind without a name is outside the catalogue: the right verdict is "unexplained". A kind whose
names a version of dnanalyze does not know yet is outside that version's catalogue. The name
`BASELINE` says that the baseline model has a parameter for it: nothing need be added.
"""

from __future__ import annotations

from dataclasses import dataclass

BASELINE = ""


@dataclass(frozen=True)
class Answer:
    """Names that are right for a kind, the proper one first; the reason where it is not plain."""

    names: tuple[str, ...] = ()
    reason: str = ""


def _same(*names: str) -> dict[str, Answer]:
    return {name: Answer((name,)) for name in names}


ANSWERS: dict[str, Answer] = {
    **_same(
        "amp_glow", "black_clipping", "cfa_mismatch", "column_fpn", "column_gain", "column_noise",
        "column_taps", "cosmic_rays", "crosstalk", "dark_current_steps", "dark_gradient",
        "defect_lines", "denoise", "digital_gain", "dpc", "flicker_fpn", "flicker_noise",
        "heavy_tailed_read_noise", "hot_clusters", "hot_pixels", "missing_codes", "offset_drift",
        "periodic_pattern", "persistence", "row_fpn", "row_noise", "rts", "serial_noise",
        "stuck_pixels", "temporal_denoise",
    ),
    # forms of an effect of the catalogue
    "edge_glow": Answer(("amp_glow",), "glow along all four edges, no corner of its own"),
    "narrow_hot_pixels": Answer(("hot_pixels",), "all hot pixels have one rate"),
    "power_law_hot_pixels": Answer(("hot_pixels",), "rates follow a power law"),
    "damage_hot_pixels": Answer(("hot_pixels",), "exponential rates of displacement damage"),
    "offset_jumps": Answer(("offset_drift",), "white offsets of whole frames, no walk"),
    "dark_jitter": Answer(
        ("offset_drift",), "the dark charge of whole frames scaled at random: `scaled`, `white`"
    ),
    "flicker_cutoff": Answer(("flicker_noise",), "1/f above a lower cutoff, white below"),
    "alternating_flicker": Answer(
        ("flicker_noise",), "1/f noise of two chains, one for even and one for odd columns"
    ),
    "output_flicker": Answer(
        ("flicker_noise",), "1/f noise of outputs that read strips side by side"
    ),
    "student_t_noise": Answer(("heavy_tailed_read_noise",), "Student's t in every pixel"),
    "read_noise_spread": Answer(
        (BASELINE, "heavy_tailed_read_noise"),
        "sigma differs from pixel to pixel: `spread` of read_noise, in one frame a heavy tail",
    ),
    "read_noise_populations": Answer(
        ("noisy_pixels", "rts"),
        "a few pixels with larger Gaussian noise; within one series telegraph noise of a fast "
        "trap looks the same",
    ),
    "interleaved_channels": Answer(
        ("column_taps", "periodic_pattern", "cfa_mismatch"),
        "a fixed offset of every n-th column; of two it is a fixed pattern of period 2",
    ),
    "amplifier_segments": Answer(("column_taps",), "vertical strips, each with its offset"),
    "dead_columns": Answer(
        ("scaled_lines",), "columns that collect no charge, read as usual"
    ),
    "dead_pixels": Answer(
        ("dead_pixels",), "pixels that collect no charge; they keep their read noise"
    ),
    "tracks": Answer(("cosmic_rays",), "particles along straight tracks"),
    "single_hits": Answer(("cosmic_rays",), "particles that hit one pixel each"),
    "anisotropic_crosstalk": Answer(("crosstalk",), "more along the rows than along the columns"),
    "dark_shading": Answer(
        ("dark_shading", "dark_gradient"),
        "a smooth random factor of the dark current; a steep one is nearly a plane and a bowl",
    ),
    "sar_converter": Answer(("missing_codes",), "unequal code widths of a successive converter"),
    "offset_plane": Answer(
        ("offset_gradient",), "a tilt of the offset, without charge and its shot noise"
    ),
    "transfer_tails": Answer(
        ("transfer_tails",), "charge-transfer inefficiency: tails behind hot pixels"
    ),
    "multiplication": Answer(
        ("electron_multiplication",), "an electron-multiplying register's excess noise"
    ),
    "clipping_at_zero": Answer(
        (BASELINE, "black_clipping"), "the converter of the baseline has no codes below 0 either"
    ),
    # no effect of the catalogue has these laws
    "edge_offset": Answer((), "offsets that rise towards the edges, without charge"),
    "quadrant_offsets": Answer((), "four quadrants, each with its offset and gain"),
    "noise_at_edges": Answer((), "read noise that rises towards the edges"),
    "channel_noise": Answer((), "read noise that differs between interleaved channels"),
    "nonlinearity": Answer((), "a response that bends with charge"),
    "concentric_rings": Answer((), "growth rings of the wafer"),
}  # fmt: skip


# What every sensor of a generator has: an effect that its captures support, and nothing hidden.
IN_EVERY_SENSOR: dict[str, frozenset[str]] = {
    # a normal dark current nonuniformity; claimed of the ordinary ones (`pattern_skewness`)
    "pyxel": frozenset({"dark_current_fpn"}),
}


def names_of(kind: str) -> tuple[str, ...]:
    """Right names of a kind; a kind of the virtual sensor outside the catalogue has none."""
    return ANSWERS.get(kind, Answer()).names
