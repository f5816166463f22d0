"""Cameras of getframes 2.6.1: a configuration changed by one field or two.

What it draws, read in its frames: hot pixels all at one factor of their neighbours' dark current
(one narrow peak), dark current that doubles every few degrees, fixed maps keyed by one seed.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from third_party.case import FRAMES, SHAPE, Claim, Drawn, Point, Recipe, near

Claims = Callable[[dict[str, Any]], tuple[Claim, ...]]


def draw_camera(rng: np.random.Generator) -> dict[str, Any]:
    """Ordinary values of a scientific CMOS camera, e- and ADU."""
    gain = float(np.exp(rng.uniform(np.log(0.5), np.log(2.0))))  # e-/ADU
    return {
        "name": "stranger",
        "sensor_type": "CMOS",
        "resolution": SHAPE,
        "pixel_size_um": 9.0,
        "quantum_efficiency": 0.7,
        "full_well_e": 20000.0,
        "bit_depth": 16,
        "gain_e_per_adu": gain,
        "bias_offset_adu": float(rng.integers(150, 400)),
        "read_noise_e": max(float(rng.uniform(1.5, 5.0)), gain),
        "dark_current_e_per_s": float(np.exp(rng.uniform(np.log(2), np.log(8)))),
        "dark_current_ref_temp_c": 20.0,
        "dark_current_doubling_temp_c": float(rng.uniform(5.5, 7.5)),
        "dark_current_nonuniformity": float(rng.uniform(0.1, 0.4)),
        "bias_pixel_spread_adu": float(rng.uniform(0.3, 0.8)) / gain,
        "fixed_pattern_seed": int(rng.integers(1 << 30)),
    }


TEMPERATURES = (10.0, 20.0, 30.0, 40.0, 50.0)
EXPOSURE_S = 1.0


def dark_e(camera: dict[str, Any], celsius: float = TEMPERATURES[-1]) -> float:
    """Mean dark charge of an exposure."""
    doubled = (celsius - camera["dark_current_ref_temp_c"]) / camera["dark_current_doubling_temp_c"]
    return camera["dark_current_e_per_s"] * EXPOSURE_S * 2.0**doubled


def noise_adu(camera: dict[str, Any], celsius: float = TEMPERATURES[0]) -> float:
    """Temporal noise of a pixel, ADU."""
    variance = camera["read_noise_e"] ** 2 + dark_e(camera, celsius)
    return float(np.sqrt(variance / camera["gain_e_per_adu"] ** 2 + 1 / 12))


def pattern_adu(camera: dict[str, Any], celsius: float = TEMPERATURES[-1]) -> float:
    """Standard deviation over the pixels of the mean of the frames of a point, ADU."""
    spread = np.sqrt(np.expm1(camera["dark_current_nonuniformity"] ** 2))
    fixed = spread * dark_e(camera, celsius) / camera["gain_e_per_adu"]
    noise = noise_adu(camera, celsius) / np.sqrt(FRAMES)
    return float(np.sqrt(fixed**2 + camera["bias_pixel_spread_adu"] ** 2 + noise**2))


def frames_of(camera: dict[str, Any], seed: int) -> dict[Point, np.ndarray]:
    """A temperature series of dark frames."""
    from getframes import Camera, CameraConfig

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        device = Camera(CameraConfig.from_dict(camera))
    stacks = {}
    for number, celsius in enumerate(TEMPERATURES):
        series = device.dark_series(EXPOSURE_S, FRAMES, celsius, seed=seed + number)
        codes = np.stack([np.asarray(f.data) for f in series])
        stacks[Point(celsius, EXPOSURE_S)] = np.minimum(codes, 65535).astype(np.uint16)
    return stacks


def drawn(
    changes: Callable[[dict[str, Any], float], dict[str, Any]],
    claims: Claims,
    amount: float,
    seed: int,
) -> Drawn:
    """A camera at random with these fields changed."""
    camera = draw_camera(np.random.default_rng([seed, 0]))
    camera |= changes(camera, amount)
    return Drawn(frames_of(camera, seed % (1 << 31)), claims(camera), camera)


Changes = Callable[[dict[str, Any], float], dict[str, Any]]


def _of(
    field: str, unit: Callable[[dict[str, Any]], float] = lambda c: 1.0, **more: Any
) -> Changes:
    """One field at the amount times a unit of this camera, with constant others."""
    return lambda camera, amount: {field: amount * unit(camera)} | more


def _noise(camera: dict[str, Any]) -> float:
    return noise_adu(camera)


def ordinary(c: dict[str, Any]) -> tuple[Claim, ...]:
    return (
        near("charge_slope", 1 / c["gain_e_per_adu"], 0.12),
        Claim("row_noise_sd", 0, 0.03 * noise_adu(c), 0),
        Claim("column_fpn_sd", 0, 0.08 * pattern_adu(c, TEMPERATURES[0]), 0),
        Claim("smooth_rms", 0, 0.2 * pattern_adu(c, TEMPERATURES[0]), 0),
    )


def hot(c: dict[str, Any]) -> tuple[Claim, ...]:
    """One narrow peak: the spread of the heights is that of the dark current of all pixels."""
    high = (c["hot_pixel_factor"] - 1) * dark_e(c) / c["gain_e_per_adu"]
    half = {"sigmas": 0.35 * high / pattern_adu(c)}
    return (
        near("hot_share", c["hot_pixel_fraction"], 0.45, options=half),
        near("hot_height", high, 0.25, options=half),
        Claim("hot_spread", 0, 1.3 * c["dark_current_nonuniformity"] + 0.1, -1, half),
    )


def noise_spread(c: dict[str, Any]) -> tuple[Claim, ...]:
    share = (c["read_noise_e"] / c["gain_e_per_adu"] / noise_adu(c)) ** 4
    kurtosis = 3 * share * (np.exp(4 * c["read_noise_nonuniformity"] ** 2) - 1)
    return (Claim("temporal_kurtosis", 0.5 * kurtosis, 1.5 * kurtosis + 0.3, 0),)


def populations(c: dict[str, Any]) -> tuple[Claim, ...]:
    """Every noisy pixel is Gaussian over the frames: three times its variance, no two levels."""
    p, m = c["read_noise_rts_fraction"], c["read_noise_rts_factor"]
    kurtosis = 3 * ((1 - p + p * m**4) / (1 - p + p * m**2) ** 2 - 1)
    share = (c["read_noise_e"] / c["gain_e_per_adu"] / noise_adu(c)) ** 4
    return (Claim("temporal_kurtosis", 0.4 * share * kurtosis, 1.5 * kurtosis, 0),)


def channels(c: dict[str, Any]) -> tuple[Claim, ...]:
    period = {"period": c["readout_channel_count"]}
    return (near("interleaved_sd", c["bias_channel_spread_adu"], 0.25, point=0, options=period),)


def channel_noise(c: dict[str, Any]) -> tuple[Claim, ...]:
    return (Claim("column_noise_spread", 0.3 * c["read_noise_channel_nonuniformity"], 1.0, 0),)


def edge_noise(c: dict[str, Any]) -> tuple[Claim, ...]:
    return (Claim("edge_noise_ratio", 1 + 0.3 * (c["read_noise_edge_factor"] - 1), 9.0, 0),)


def jumps(c: dict[str, Any]) -> tuple[Claim, ...]:
    e = c["readout_common_mode_noise_adu"]
    return (Claim("frame_offset_sd", 0.25 * e, 2.0 * e, 0),)


def edge_glow(c: dict[str, Any]) -> tuple[Claim, ...]:
    """The same at every temperature: it does not grow with the dark current."""
    y, x = np.indices(SHAPE)
    away = np.minimum.reduce([y, SHAPE[0] - 1 - y, x, SHAPE[1] - 1 - x])
    profile = np.exp(-away / c["detector_glow_edge_scale_px"])
    profile *= c["detector_glow_e_per_s"] * EXPOSURE_S / profile.mean() / c["gain_e_per_adu"]
    ring = float(np.median(profile[away < 4]) - np.median(profile[64:-64, 64:-64]))
    return (near("edge_excess", ring, 0.2, point=0), near("edge_excess", ring, 0.3, point=2))


def tails(c: dict[str, Any]) -> tuple[Claim, ...]:
    lost = c["cti"] * SHAPE[0] / 2
    return (Claim("trailing_share", 0.3 * lost, 3.0 * lost, -1, {"sigmas": 15.0}),)


def crosstalk(c: dict[str, Any]) -> tuple[Claim, ...]:
    shot = 1 - (noise_adu(c, -273.0) / noise_adu(c, TEMPERATURES[-1])) ** 2
    return (near("neighbour_correlation", 2 * c["ipc_coupling"] * shot, 0.35),)


def quadrants(c: dict[str, Any]) -> tuple[Claim, ...]:
    half = {"rows": [SHAPE[0] // 2], "columns": [SHAPE[1] // 2]}
    size = float(np.std(c["amplifier_offsets_adu"]))
    return (near("segment_sd", size, 0.25, point=0, options=half),)


def strips(c: dict[str, Any]) -> tuple[Claim, ...]:
    edges = {"columns": list(c["amplifier_boundaries_x_px"])}
    size = float(np.std(c["amplifier_offsets_adu"]))
    return (near("segment_sd", size, 0.25, point=0, options=edges),)


def hits(c: dict[str, Any]) -> tuple[Claim, ...]:
    area = SHAPE[0] * SHAPE[1]
    rate = c["cosmic_ray_rate_per_cm2_s"] * (c["pixel_size_um"] * 1e-4) ** 2 * EXPOSURE_S
    length = max(1.0, c.get("cosmic_ray_track_length_px", 0.0))
    share = rate * length
    return (Claim("transient_share", 0.3 * share, 2.0 * share + 3 / area),)


def columns(c: dict[str, Any]) -> tuple[Claim, ...]:
    return (Claim("dark_columns", 0.5 / SHAPE[1], 4.0 * c["bad_column_fraction"]),)


def dead(c: dict[str, Any]) -> tuple[Claim, ...]:
    return (Claim("low_share", 0, 1.5 * c["dead_pixel_fraction"]),)


def tilted(c: dict[str, Any]) -> tuple[Claim, ...]:
    """A plane and column offsets, both without charge: the same size hot and cold."""
    size = c["bias_structure_amplitude_adu"]
    return (
        Claim("column_fpn_sd", 0.05 * size, size, 0),
        Claim("plane_rms", 0.02 * size, size, 0),
    )


def edge_offset(c: dict[str, Any]) -> tuple[Claim, ...]:
    ring = c["bias_edge_amplitude_adu"] * np.exp(-1.5 / c["bias_edge_scale_px"])
    return (near("edge_excess", ring, 0.3, point=0),)


def multiplied(c: dict[str, Any]) -> tuple[Claim, ...]:
    """The charge counts gain x F^2, F^2 = 2."""
    return (near("charge_slope", 2 * c["em_gain"] / c["gain_e_per_adu"], 0.2),)


def bent(c: dict[str, Any]) -> tuple[Claim, ...]:
    """A slope that falls by twice the compression between the ends."""
    share = c["nonlinearity"] * dark_e(c) / c["full_well_e"]
    gain = 1 / c["gain_e_per_adu"]
    return (Claim("charge_slope", gain * (1 - 5 * share), gain * (1 - 1.5 * share)),)


def clipped(c: dict[str, Any]) -> tuple[Claim, ...]:
    return (Claim("lowest_code_share", 0.005, 0.6, 0),)


def _amplifiers(camera: dict[str, Any], amount: float) -> dict[str, Any]:
    levels = amount * noise_adu(camera) * np.array([-1.0, 0.8, 1.1, -0.9])
    return {"amplifier_layout": (2, 2), "amplifier_offsets_adu": tuple(map(float, levels))}


def _strips(camera: dict[str, Any], amount: float) -> dict[str, Any]:
    levels = amount * noise_adu(camera) * np.array([-0.7, 1.0, -0.3])
    return {
        "amplifier_layout": (1, 3),
        "amplifier_boundaries_x_px": (60, 170),
        "amplifier_offsets_adu": tuple(map(float, levels)),
    }


def _hits(length: float) -> Changes:
    """``amount`` hits a frame."""

    def changes(camera: dict[str, Any], amount: float) -> dict[str, Any]:
        area = SHAPE[0] * SHAPE[1] * (camera["pixel_size_um"] * 1e-4) ** 2
        return {
            "cosmic_ray_rate_per_cm2_s": amount / (area * EXPOSURE_S),
            "cosmic_ray_track_length_px": length,
        }

    return changes


def _bent(camera: dict[str, Any], amount: float) -> dict[str, Any]:
    return {"nonlinearity": amount, "full_well_e": 3.0 * dark_e(camera)}


def _multiplied(camera: dict[str, Any], amount: float) -> dict[str, Any]:
    return {
        "sensor_type": "EMCCD",
        "em_gain": amount,
        "clock_induced_charge_e": 0.05,
        "read_noise_e": camera["read_noise_e"] * amount / 2,
        "gain_e_per_adu": camera["gain_e_per_adu"] * amount / 2,
        "full_well_e": 80000.0,
        "output_full_well_e": 1e7,
    }


def _tails(camera: dict[str, Any], amount: float) -> dict[str, Any]:
    return {"cti": amount, "hot_pixel_fraction": 0.004, "hot_pixel_factor": 25.0}


# name: (kinds, changes, claims, moderate, strong)
EFFECTS: dict[str, tuple[tuple[str, ...], Changes, Claims, float, float]] = {
    "hot_pixels": (("narrow_hot_pixels",), _of("hot_pixel_fraction", hot_pixel_factor=15.0), hot,
                   0.0015, 0.008),
    "noise_spread": (("read_noise_spread",), _of("read_noise_nonuniformity"), noise_spread,
                     0.25, 0.5),
    "noise_populations": (("read_noise_populations",),
                          _of("read_noise_rts_factor", read_noise_rts_fraction=0.02),
                          populations, 2.65, 4.0),
    "channels": (("interleaved_channels",),
                 _of("bias_channel_spread_adu", _noise, readout_channel_count=4), channels,
                 0.25, 0.8),
    "channel_noise": (("channel_noise",),
                      _of("read_noise_channel_nonuniformity", readout_channel_count=4),
                      channel_noise, 0.2, 0.5),
    "edge_noise": (("noise_at_edges",),
                   _of("read_noise_edge_factor", read_noise_edge_scale_px=20.0), edge_noise,
                   1.6, 3.0),
    "common_mode": (("offset_jumps",), _of("readout_common_mode_noise_adu", _noise), jumps,
                    0.3, 1.0),
    "edge_glow": (("edge_glow",),
                  _of("detector_glow_e_per_s", lambda c: c["read_noise_e"] ** 2,
                      detector_glow_edge_scale_px=12.0), edge_glow, 0.1, 0.6),
    "transfer": (("transfer_tails", "narrow_hot_pixels"), _tails, tails, 2e-4, 1e-3),
    "crosstalk": (("crosstalk",), _of("ipc_coupling"), crosstalk, 0.012, 0.03),
    "quadrants": (("quadrant_offsets",), _amplifiers, quadrants, 0.4, 1.5),
    "strips": (("amplifier_segments",), _strips, strips, 0.4, 1.5),
    "single_hits": (("single_hits",), _hits(0.0), hits, 15.0, 100.0),
    "tracks": (("tracks",), _hits(12.0), hits, 5.0, 25.0),
    "bad_columns": (("dead_columns",), _of("bad_column_fraction"), columns, 0.015, 0.04),
    "dead_pixels": (("dead_pixels",), _of("dead_pixel_fraction"), dead, 0.002, 0.01),
    "bias_structure": (("column_fpn", "offset_plane"),
                       _of("bias_structure_amplitude_adu", _noise), tilted, 1.5, 5.0),
    "edge_offset": (("edge_offset",),
                    _of("bias_edge_amplitude_adu", _noise, bias_edge_scale_px=15.0),
                    edge_offset, 0.7, 3.0),
    "multiplication": (("multiplication",), _multiplied, multiplied, 10.0, 100.0),
    "nonlinearity": (("nonlinearity",), _bent, bent, 0.15, 0.45),
    "black_clipping": (("clipping_at_zero",), _of("bias_offset_adu", _noise), clipped,
                       1.8, 0.5),
}  # fmt: skip

PAIRS = (
    ("hot_pixels", "channels"),
    ("crosstalk", "common_mode"),
    ("single_hits", "noise_spread"),
    ("edge_glow", "bad_columns"),
)
ORDINARY = 5


def _single(name: str) -> Recipe:
    hides, changes, claims, *amounts = EFFECTS[name]
    return Recipe(hides, lambda a, seed: drawn(changes, claims, a, seed), tuple(amounts))


def _pair(names: tuple[str, str]) -> Recipe:
    one, two = (EFFECTS[n] for n in names)

    def changes(camera: dict[str, Any], amount: float) -> dict[str, Any]:
        return one[1](camera, one[4]) | two[1](camera, two[4])

    return Recipe(one[0] + two[0], lambda a, seed: drawn(changes, lambda c: (), a, seed))


RECIPES: dict[str, Recipe] = {
    **{name: _single(name) for name in EFFECTS},
    **{"+".join(names): _pair(names) for names in PAIRS},
    **{
        f"ordinary_{n}": Recipe((), lambda a, seed: drawn(lambda c, a: {}, ordinary, a, seed))
        for n in range(1, ORDINARY + 1)
    },
}
