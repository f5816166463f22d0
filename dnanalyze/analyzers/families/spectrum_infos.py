"""What the statistics of the spectra are, and what a misfit of each says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from dnanalyze.analyzers.spectra.modes import PROFILE_BANDS, RADIAL_BANDS, STRUCTURE_BANDS
from dnanalyze.analyzers.statistics import Scale, StatisticInfo

_OF = {
    "frame": "of the single frame",
    "pattern": "of the DSNU",
    "temporal": "of the temporal noise",
}


def band_names(edges: Sequence[float]) -> Iterator[tuple[str, float, float]]:
    """Label, lower and upper edge of each band, cycles/pixel."""
    for low, high in pairwise(edges):
        yield f"{low:g}_{high:g}", low, high


def profile_names() -> Iterator[tuple[str, float, float]]:
    """As `band_names` for the profiles along u and v, the three lowest frequencies first."""
    yield "first", 0.0, 0.5
    yield from band_names(PROFILE_BANDS)


def _power(name: str, title: str, compared: bool = True) -> StatisticInfo:
    return StatisticInfo(
        name, "spectrum", "DN^2", title, Scale.LOG,
        high=f"the measured {title} is {{ratio}} times the model's",
        low=f"the measured {title} is only {{ratio}} times the model's",
        compared=compared,
    )  # fmt: skip


def _band_text(label: str) -> str:
    if label == "first":
        return "at the lowest three frequencies"
    low, high = label.split("_")
    return f"below {high} c/px" if low == "0" else f"at {low} to {high} c/px"


def _of_part(part: str) -> Iterator[StatisticInfo]:
    of = _OF[part]
    for label, _, _ in band_names(RADIAL_BANDS):
        # the single frame follows from the other two; with one frame only, it is all there is
        yield _power(f"{part}_psd_{label}", f"power {of} {_band_text(label)}")
    for kind in ("columns", "rows"):
        for label, _, _ in band_names(STRUCTURE_BANDS):
            lines = f"whole {kind}"
            what = f"of {lines} {of}" if part == "frame" else f"{of} of {lines}"
            title = f"power {what} {_band_text(label)}"
            yield _power(f"{part}_{kind}_{label}", title)
    for axis, way in (("u", "along the rows"), ("v", "along the columns")):
        for label, _, _ in profile_names():
            yield _power(f"{part}_{axis}_{label}", f"power {of} {way} {_band_text(label)}")
    yield from _lines_of(part, of)
    for label, span in (("low", "0.005 to 0.05"), ("mid", "0.05 to 0.2"), ("high", "0.2 to 0.5")):
        yield _told(f"{part}_slope_{label}", "1", f"log-log slope {of} at {span} c/px")
    yield _told(f"{part}_corner_frequency", "c/px", f"corner frequency {of}")
    yield _told(f"{part}_hf_mf", "1", f"high-to-mid-frequency ratio {of}", Scale.LOG)


def _lines_of(part: str, of: str) -> Iterator[StatisticInfo]:
    yield StatisticInfo(
        f"{part}_line", "spectrum", "1", f"strongest spectral peak {of} over its surroundings",
        Scale.LOG,
        high="the strongest spectral peak is {ratio} times as high as in the model: interference "
        "from a clock or supply, or a periodic pattern",
        low="the model has a spectral peak that the measurement lacks",
    )  # fmt: skip
    yield StatisticInfo(
        f"{part}_line_in_step", "spectrum", "1",
        f"phase coherence over the field of the strongest peak {of}",
        high="the strongest spectral peak is more phase-coherent over the field than in the "
        "model: a single plane wave",
        low="the strongest spectral peak is not phase-coherent over the field, as a plane "
        "wave would be: rings, a chirp, a beat, or a part of the field",
    )  # fmt: skip
    yield from _placed(f"{part}_line", f"the strongest peak {of}")
    name, what = f"{part}_axis_line", f"strongest peak {of} of whole rows or columns"
    yield _told(name, "1", f"{what}, over its surroundings", Scale.LOG)
    yield from _placed(name, f"the {what}")


def _placed(name: str, what: str) -> Iterator[StatisticInfo]:
    for axis, way in (("u", "horizontal"), ("v", "vertical")):
        yield _told(f"{name}_{axis}", "c/px", f"{way} frequency of {what}")
    yield _told(f"{name}_amplitude", "DN", f"amplitude of {what}")


def _told(name: str, unit: str, title: str, scale: Scale = Scale.LINEAR) -> StatisticInfo:
    """A value for information alone."""
    return StatisticInfo(name, "spectrum", unit, title, scale, compared=False)


def _nyquist(part: str) -> Iterator[StatisticInfo]:
    for label, what, why in (
        ("10", "odd and even columns", "two readout chains, or a colour pattern"),
        ("01", "odd and even rows", "two readout chains, or a colour pattern"),
        ("11", "the two fields of a checkerboard", "a colour pattern or shared pixels"),
    ):
        yield StatisticInfo(
            f"{part}_nyquist_{label}", "spectrum", "1",
            f"difference between {what}" + (f" {_OF[part]}" if part == "frame" else ""),
            Scale.RATIO,
            high=f"{what} differ more than in the model: {why}",
            low=f"{what} differ less than in the model",
        )  # fmt: skip


INFOS: tuple[StatisticInfo, ...] = (
    *_of_part("frame"),
    *_of_part("pattern"),
    *_of_part("temporal"),
    _told(
        "frame_hf_mf_quiet",
        "1",
        "high-to-mid-frequency ratio of the single frame without hits (3 robust sigma) and their "
        "neighbours",
        Scale.LOG,
    ),
    *_nyquist("pattern"),
    *_nyquist("frame"),
)
