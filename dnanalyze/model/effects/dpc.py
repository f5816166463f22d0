"""Defect-pixel correction: outlying pixels replaced by what their neighbours say."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter
from dnanalyze.model.evidence import bounded, excess, shows, strongest, typical_positive

_CALIBRATION_FRAMES = 2
_EXCESS = (("excess_4", 4.0), ("excess_8", 8.0), ("excess_16", 16.0))
FAR = 3.0  # times the usual threshold from which that is looked at too
_LEAST = 1.0, 2.0  # noise: net signal that a multiple of the median may be taken of
_ENOUGH = 5.0  # pixels that should stand out
_TAIL = (  # quantiles of the pattern, and the share of the pixels above them
    ("pattern_q0.9", 0.1), ("pattern_q0.99", 0.01), ("pattern_q0.999", 1e-3),
    ("pattern_q0.9999", 1e-4),
)  # fmt: skip


@dataclass(frozen=True)
class Dpc(Effect):
    """Replaces pixels that stand out from their 8 (or 24) neighbours, or those on a fixed list."""

    name: ClassVar[str] = "dpc"
    stage: ClassVar[Stage] = Stage.CORRECTION
    varies: ClassVar[str] = "digital"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = "Defect-pixel correction: hot pixels are hidden in the 'raw' data."
    physics: ClassVar[str] = (
        "Many sensors and cameras hide hot pixels before the file is written. A dynamic correction "
        "compares every pixel with its neighbours in each frame: kind 'excess' replaces it by "
        "their median (or mean) where it exceeds the largest of them by more than a threshold, "
        "'median' where it stands above their median by more than that, 'clamp' caps it at the "
        "largest neighbour (the 'star eater' of astronomers), 'ratio' replaces it where "
        "its net signal is a multiple of the largest neighbour's, 'multiple' where it is one of "
        "their median's. A 'static' correction replaces the pixels of a list made in the factory, "
        "hot or not. The true tail of the dark current is cut, the more the hotter the sensor, so "
        "the dark signal looks better than it is and faint stars vanish. In a mosaic the "
        "neighbours are those of the same colour (spacing 2). "
        "What to do: switch it off (a register, a raw mode), or model it; the tail above the "
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
        "denoise": "moves pixels that do not stand out too: the cold frames lose high frequencies, "
        "minima are as rare as maxima",
        "crosstalk": "spreads every hot pixel alike, by a constant share; none is cut",
        "hot_pixels": "the opposite: a tail beyond the model's, isolated pixels kept",
    }
    reach: ClassVar[int] = 4

    threshold: float = parameter(
        8.0, "DN", 0.01, 1e5, "by how much a pixel must stand out; least median (multiple)"
    )
    factor: float = parameter(
        2.0, "1", 1.0, 100.0, "multiple of the largest neighbour (ratio), of the median (multiple)"
    )
    black: float = parameter(0.0, "DN", -1e5, 1e5, "level of no signal (ratio, multiple)", "linear")
    fraction: float = parameter(5e-4, "1", 1e-6, 0.05, "share of pixels on the list (static)")
    warmer: float = parameter(
        0.0, "C", -100.0, 200.0, "how far above the reference the list was made (static)", "held"
    )
    kind: str = choice("excess", "rule", "excess", "median", "clamp", "ratio", "multiple", "static")
    sides: str = choice("hot", "which outliers", "hot", "both")
    replacement: str = choice(
        "median", "what of the neighbours takes its place", "median", "midpoint", "mean"
    )
    unit: str = choice("DN", "of the threshold (median): DN, or neighbours' spread", "DN", "local")
    neighbours: int = choice(8, "how many are looked at (excess, clamp, ratio)", 8, 24)
    spacing: int = choice(1, "distance of neighbours: 2 within a colour of a mosaic", 1, 2)

    def idle(self) -> tuple[str, ...]:
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
            frames = [site.calibration(-1 - n, warmer) for n in range(_CALIBRATION_FRAMES)]
            steady = np.minimum.reduce(frames)  # what is bright once only is not on the list
            count = round(self.value("fraction", site.reference) * steady.size)
            listed = np.zeros(steady.size, bool)
            if count:
                listed[np.argsort(-steady.reshape(-1), kind="stable")[:count]] = True
            return np.packbits(listed)

        whole = np.unpackbits(site.share("list", make), count=site.shape[0] * site.shape[1])
        return whole.reshape(site.shape)[site.window.slices].astype(bool)

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """Threshold from where pixels that stand out begin to be rarer than modelled."""
        rare = [k for name, k in _EXCESS if shows(clues, [name], -1)]
        tied = shows(clues, ["ties_max8"])
        ranks = shows(clues, ["frame_pmax8", "pattern_pmax8", "temporal_pmax8"], -1)
        sparse = shows(clues, ["hot_count_16", "hot_count_32", "hot_count_64"], -1)
        cut = shows(clues, [name for name, _ in _TAIL[-2:]], -1)
        if not (rare or tied or ranks or sparse or cut):
            return []
        noise = typical_positive(np.asarray(clues.measured("temporal_noise_core"), float)) or 1.0
        usual = bounded(cls, "threshold", (rare[0] if rare else 4.0) * noise)
        threshold = bounded(cls, "threshold", _threshold(clues) or usual)
        near = min(threshold, usual)
        found: list[Dpc] = []
        standing = bool(rare or ranks or tied)
        if standing:
            found.append(cls(threshold, kind="excess"))
            found.append(cls(near, kind="median"))
        # the fit without it has made the tail as short as the correction leaves it: then few are
        # missing where it begins
        low, high = (bounded(cls, "threshold", k * noise) for k in _LEAST)
        if rare:
            found += [cls(high, kind="multiple"), cls(low, kind="multiple")]
        if standing:
            found.append(cls(bounded(cls, "threshold", 0.2 * noise), kind="clamp"))
        if sparse or cut:
            found.append(cls(kind="static"))
        if standing and threshold > FAR * usual:
            found.append(cls(usual, kind="excess"))
        if rare:
            found.append(cls(low, kind="ratio"))
        if standing:
            found.append(cls(near, kind="excess", sides="both"))
            found.append(cls(threshold, kind="clamp"))
        # idle in most kinds, but at hand should it turn out to be another
        share, warmer = bounded(cls, "fraction", _listed(clues)), _hottest(clues)
        black = _darkest(clues)
        return [replace(guess, black=black, fraction=share, warmer=warmer) for guess in found]


def _darkest(clues: Clues) -> float:
    """DN of the setting with the least signal."""
    level = np.asarray(clues.measured("median"), float)
    return float(np.nanmin(level)) if np.isfinite(level).any() else 0.0


def _hottest(clues: Clues) -> float:
    """C above the reference of the warmest setting: lists are made where defects show."""
    known = [p.temperature_c for p in clues.points if p.temperature_c is not None]
    origin = clues.reference.temperature_c
    return max(known) - origin if known and origin is not None else 0.0


def _threshold(clues: Clues) -> float:
    """DN above all neighbours from which pixels are gone, over all settings; 0: not to be seen.

    The noise, and with it what so many deviations are in DN, differs from setting to setting, so
    the counts bracket the threshold closer than those of one setting could.
    """
    noise = np.asarray(clues.measured("temporal_noise_core"), float)
    leads, left, weights = [], [], []
    for name, k in _EXCESS:
        expected = np.asarray(clues.simulated(name), float)
        seen = np.asarray(clues.measured(name), float)
        told = np.isfinite(noise * expected * seen) & (expected > _ENOUGH)
        leads += list(k * noise[told])
        left += list(np.minimum(seen[told] / expected[told], 1.0))
        weights += list(np.sqrt(expected[told]))
    if not leads:
        return 0.0
    order = np.argsort(leads, kind="stable")
    lead, share, weight = (np.array(v)[order] for v in (leads, left, weights))
    # what is missing below a threshold, and what is left above it, speak against it
    below = np.append(0.0, np.cumsum(weight * (1.0 - share)))
    above = np.append(np.cumsum((weight * share)[::-1])[::-1], 0.0)
    at = int(np.argmin(below + above))
    ends = np.concatenate([lead[:1] / 2.0, lead, lead[-1:] * 2.0])
    return float(np.sqrt(ends[at] * ends[at + 1]))


def _listed(clues: Clues) -> float:
    """Share of the pixels that the model has and the measurement lacks above its 99.99 % quantile.

    At the setting where that is farthest off; between quantiles the logarithm of the share goes
    with their value.
    """
    setting = strongest(clues, [_TAIL[-1][0]]) or 0
    top = float(np.asarray(clues.measured(_TAIL[-1][0]), float)[setting])
    modelled = [float(np.asarray(clues.simulated(name), float)[setting]) for name, _ in _TAIL]
    if not np.all(np.isfinite([top, *modelled])):
        return typical_positive(-excess(clues, "hot_count_16")) / np.prod(clues.shape)
    return math.exp(np.interp(top, modelled, [math.log(share) for _, share in _TAIL]))
