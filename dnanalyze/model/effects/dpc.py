"""Defect-pixel correction: outlying pixels replaced by what their neighbours say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter

_CALIBRATION_FRAMES = 2


@dataclass(frozen=True)
class Dpc(Effect):
    """Replaces pixels that stand out from their 8 (or 24) neighbours, or those on a fixed list."""

    name: ClassVar[str] = "dpc"
    stage: ClassVar[Stage] = Stage.CORRECTION
    varies: ClassVar[str] = "digital"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = (
        "Defect-pixel correction: hot pixels are replaced in frames declared as raw."
    )
    physics: ClassVar[str] = (
        "Many sensors and cameras hide hot pixels before the file is written. A dynamic "
        "correction compares every pixel with its neighbours in each frame: kind 'excess' "
        "replaces it by their median (or mean) where it exceeds the largest of them by more "
        "than a threshold, 'median' where it stands above their median by more than that, "
        "'clamp' caps it at the largest neighbour (the 'star eater' of astronomers), 'ratio' "
        "replaces it where its net signal is a multiple of the largest neighbour's, "
        "'multiple' where it is one of their median's. A 'static' correction replaces the "
        "pixels of a list made in the factory, hot or not. The true tail of the dark current "
        "is cut, at high temperature most, so the dark signal is underestimated and faint "
        "stars are removed. In a mosaic the neighbours are those of the same colour (spacing "
        "2). Remedy: switch it off (a register, a raw mode), or model it; the tail above the "
        "threshold cannot be recovered from corrected frames."
    )
    formula: ClassVar[str] = (
        "excess: y -> m where y > max8 + threshold; median: y -> m where y > m + threshold; "
        "clamp: y -> max8 where y > max8 + threshold; "
        "ratio: y -> m where y - black > factor (max8 - black) + threshold; "
        "multiple: y -> m where y - black > factor max(m - black, threshold); static: y -> m on a "
        "list"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Shelley, Sony star eater (pixel against the neighbours' maximum)",
        "Clark, raw filtering tests",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "ties_max8", "excess_8", "excess_16", "excess_4", "frame_pmax8", "pattern_pmax8",
        "temporal_pmax8", "hot_count_16", "hot_count_32",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "denoise": "changes pixels that are not outliers too: cold frames lose high frequencies, "
        "minima are as rare as maxima",
        "crosstalk": "distributes every hot pixel by the same share; none is cut",
        "hot_pixels": "the opposite: a tail beyond the model's, isolated pixels kept",
    }
    reach: ClassVar[int] = 4

    threshold: float = parameter(
        8.0,
        "DN",
        0.01,
        1e5,
        ("deviation above which a pixel is replaced; smallest median (multiple)"),
    )
    factor: float = parameter(
        2.0, "1", 1.0, 100.0, "multiple of the largest neighbour (ratio), of the median (multiple)"
    )
    black: float = parameter(0.0, "DN", -1e5, 1e5, "level of no signal (ratio, multiple)", "linear")
    fraction: float = parameter(5e-4, "1", 1e-6, 0.05, "share of pixels on the list (static)")
    warmer: float = parameter(
        0.0,
        "C",
        -100.0,
        200.0,
        ("temperature above the reference at which the list was made (static)"),
        "held",
    )
    kind: str = choice("excess", "rule", "excess", "median", "clamp", "ratio", "multiple", "static")
    sides: str = choice("hot", "which outliers", "hot", "both")
    replacement: str = choice(
        "median", "value that replaces the pixel", "median", "midpoint", "mean"
    )
    unit: str = choice(
        "DN",
        "of the threshold (median): DN, or standard deviations of the neighbours",
        "DN",
        "local",
    )
    neighbours: int = choice(8, "number of neighbours compared (excess, clamp, ratio)", 8, 24)
    spacing: int = choice(1, "distance of neighbours: 2 within a colour of a mosaic", 1, 2)

    def inactive_parameters(self) -> tuple[str, ...]:
        """What the present kind does not use."""
        used = {
            "excess": ("threshold", "sides", "replacement", "neighbours"),
            "median": ("threshold", "sides", "replacement", "unit"),
            "clamp": ("threshold", "sides", "neighbours"),
            "ratio": ("threshold", "factor", "black", "replacement", "neighbours"),
            "multiple": ("threshold", "factor", "black", "replacement"),
            "static": ("fraction", "replacement"),
        }[self.kind]
        always = ("kind", "spacing", "warmer")
        return tuple(n for n in self.parameters() if n not in (*always, *used))

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Replace what stands out; codes stay codes."""
        from dnanalyze.model import filters

        corrected = filters.planewise(lambda p, _: self._correct(p, site), signal, self.spacing)
        if self.kind == "static":
            corrected = np.where(self._listed(site), corrected, signal)
        return filters.rounded_like(signal, corrected)

    def _correct(self, plane: np.ndarray, site: Site) -> np.ndarray:
        from dnanalyze.model import filters

        threshold = self.value("threshold", site.point)
        rules = {"median": filters.MEDIAN, "midpoint": filters.MIDPOINT, "mean": filters.MEAN}
        replacement = rules[self.replacement]
        both = self.sides == "both"
        radius = 1 if self.neighbours == 8 else 2
        if self.kind == "median":
            local = self.unit == "local"
            return filters.replace_outliers(plane, threshold, local, both, replacement)
        if self.kind in ("excess", "clamp"):
            instead = filters.EXTREME if self.kind == "clamp" else replacement
            return filters.replace_excess(plane, threshold, both, radius, instead)
        factor, black = self.value("factor", site.point), self.value("black", site.point)
        if self.kind == "ratio":
            return filters.replace_by_ratio(plane, factor, threshold, black, radius, replacement)
        centre = filters.neighbour_centre(plane, replacement)
        if self.kind == "static":
            return centre
        least = np.maximum(centre - np.float32(black), np.float32(threshold))
        return np.where(plane - np.float32(black) > np.float32(factor) * least, centre, plane)

    def _listed(self, site: Site) -> np.ndarray:
        """Where the window has pixels of the list."""

        def make() -> np.ndarray:
            warmer = self.value("warmer", site.reference)
            steady = site.calibration(-1, warmer)
            for n in range(1, _CALIBRATION_FRAMES):  # what is bright once only is not on the list
                np.minimum(steady, site.calibration(-1 - n, warmer), out=steady)
            count = round(self.value("fraction", site.reference) * steady.size)
            return np.packbits(_brightest(steady.reshape(-1), count))

        whole = np.unpackbits(site.share("list", make), count=site.shape[0] * site.shape[1])
        return whole.reshape(site.shape)[site.window.slices].astype(bool)


def _brightest(values: np.ndarray, count: int) -> np.ndarray:
    """Where so many values are the largest; of equal ones the first."""
    if count == 0:
        return np.zeros(values.size, bool)
    least = np.partition(values, values.size - count)[values.size - count]
    found = values > least
    found[np.flatnonzero(values == least)[: count - np.count_nonzero(found)]] = True
    return np.asarray(found)
