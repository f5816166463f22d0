"""Fixed offsets of the columns."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter
from dnanalyze.model.evidence import (
    LINE_BANDS,
    band_excess,
    bounded,
    centre,
    line_sigma,
    named,
    shows,
    typical,
)
from dnanalyze.model.line_profile import line_profile
from dnanalyze.model.streams import Stream

_BLOCK = 4  # columns that are averaged before a transient is fitted
_FEWEST = 64  # columns from which one is looked for
CLEAR = 0.2  # share of the variance left by a transient beside which no scatter is tried


@dataclass(frozen=True)
class ColumnFpn(Effect):
    """y += c_j + a e^(-j/l); c_j = rho c_(j-1) + sqrt(1 - rho^2) sigma n_j, in every frame."""

    name: ClassVar[str] = "column_fpn"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = "Fixed vertical stripes: every column has its own offset."
    physics: ClassVar[str] = (
        "In a CMOS sensor all pixels of a column share one amplifier and one converter, whose "
        "offsets differ from column to column. The stripes stand still from frame to frame. They "
        "do not grow with temperature or exposure, since they are made after the pixel, but follow "
        "the analogue gain where the offset sits before the gain stage. Neighbouring columns that "
        "share bias lines have like offsets (rho > 0); column pairs that share a circuit may "
        "alternate (rho < 0). A CCD reads all columns through one amplifier, whose level settles "
        "after each line transfer: the columns that are read first stand off the others and "
        "approach them exponentially (`settle`, `length`). Cure: subtract the column means of "
        "optically black rows, or of a master dark; correlated double sampling in the column "
        "circuit or digital in the converter."
    )
    formula: ClassVar[str] = (
        "y_ij += c_j + a e^(-j/l), j from the column that is read first;  "
        "c_j = rho c_(j-1) + sqrt(1 - rho^2) sigma N(0,1)"
    )
    references: ClassVar[tuple[str, ...]] = (
        "El Gamal, Fowler, Min, Liu, Modeling and estimation of FPN components in CMOS image "
        "sensors, SPIE 3301 (1998)",
        "EMVA 1288 release 4.0 (DSNU1288.col)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = named("pattern_columns", reversed(LINE_BANDS))
    confused_with: ClassVar[dict[str, str]] = {
        "column_noise": "new offsets in every frame: the stripes show in differences of frames",
        "column_gain": "stripes that grow with the signal, so with temperature and exposure",
        "column_taps": "stripes that repeat with a short period, or a few wide blocks",
        "defect_lines": "a few columns far off the others, not a Gaussian spread of all",
        "dark_gradient": "power below .02 cycles/pixel alone, in rows too, that grows with "
        "exposure",
    }

    sigma: float = parameter(0.5, "DN", 1e-4, 1e3, "standard deviation of the column offsets")
    rho: float = parameter(0.0, "1", -0.95, 0.99, "correlation of neighbouring columns", "linear")
    settle: float = parameter(
        0.0, "DN", -1e4, 1e4, "offset a of the first column where the level settles", "linear"
    )
    length: float = parameter(50.0, "column", 1.0, 1e4, "columns l over which it settles by e")
    first: str = choice("left", "side that is read first", "left", "right")

    def idle(self) -> tuple[str, ...]:
        """The transient where there is none."""
        return ("settle", "length") if self.settle == 0.0 else ()

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offsets."""
        sigma = self.value("sigma", site.point) * site.gain_ratio
        signal += np.float32(sigma) * self._offsets(site)
        if self.settle != 0.0:
            signal += np.float32(site.gain_ratio) * self._settling(site)
        return signal

    def _settling(self, site: Site) -> np.ndarray:
        """The transient over the window's columns, float32, DN at the reference gain."""
        order = site.column_index
        if self.first == "right":
            order = site.shape[1] - 1 - order
        level = np.exp(-order / self.value("length", site.point))
        return (self.value("settle", site.point) * level).astype(np.float32)

    def _offsets(self, site: Site) -> np.ndarray:
        """Unit offsets of the window's columns; the recursion runs over the whole row."""
        rho = self.value("rho", site.point)
        stream = site.silicon.child("columns")
        if rho == 0.0:
            return site.columns(stream)
        return site.keep("offsets", lambda: _autoregressive(stream, site, rho))

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2; a transient adds a^2 l / (2 columns), for l far below the columns."""
        return self.value("sigma", point) ** 2

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """sigma from the unexplained power of the v = 0 axis, rho from its slope; a transient from
        the column means, where one explains most of them.
        """
        if not shows(clues, cls.fingerprint):
            return []
        sigma = line_sigma(clues, "pattern_columns", clues.shape[0])
        power = [typical(row) for row in band_excess(clues, "pattern_columns")]
        rho = _correlation(power[1], power[3])
        scattered = cls(bounded(cls, "sigma", sigma), rho)
        transient, left = _transient(clues)
        if transient is None:
            return [scattered]
        alone = bounded(cls, "sigma", math.sqrt(max(power[3], 0.0) / clues.shape[0]))
        settling = cls(alone, 0.0, *transient)
        return [settling] if left < CLEAR else [scattered, settling]


def _transient(clues: Clues) -> tuple[tuple[float, float, str] | None, float]:
    """Offset of the first column (DN), length (columns) and side of an exponential settling; the
    share of the variance that it leaves.

    Least squares of c + a e^(-j/l) on the fitted half's column means over a grid of lengths. None
    where it leaves more than half of their variance, or where the length cannot be told from a
    slope.
    """
    places, means = (part[: clues.shape[1]] for part in line_profile(clues, "columns"))
    if means.size < _FEWEST:
        return None, 1.0
    blocks = means[: means.size // _BLOCK * _BLOCK].reshape(-1, _BLOCK).mean(axis=1)
    at = places[: blocks.size * _BLOCK].reshape(-1, _BLOCK).mean(axis=1)
    level = blocks - blocks.mean()
    total = max(float(level @ level), 1e-30)
    best = (0.5 * total, 0.0, 0.0, "")
    longest = 0.4 * means.size
    for first in ("left", "right"):
        order = at if first == "left" else clues.field[1] - 1 - at
        for length in np.geomspace(_BLOCK, longest, 24):
            decay = np.exp(-(order - order.min()) / length)
            shape = decay - decay.mean()
            height = float(shape @ level / (shape @ shape))
            left = float(np.sum((level - height * shape) ** 2))
            if left < best[0]:
                start = height * math.exp(min(float(order.min()) / length, 5.0))
                best = left, start, float(length), first
    left, start, length, first = best
    return ((start, length, first) if 0.0 < length < longest else None), left / total


def _autoregressive(stream: Stream, site: Site, rho: float) -> np.ndarray:
    """First-order autoregressive line of unit variance over all columns, cut to the window."""
    from scipy.signal import lfilter

    width = site.shape[1]
    white = stream.normal(Window(0, 1, 0, width), width)[0].astype(float)
    white[1:] *= math.sqrt(1.0 - rho * rho)
    line = lfilter([1.0], [1.0, -rho], white)
    return line[site.window.left : site.window.right].astype(np.float32)


def _correlation(low: float, high: float) -> float:
    """rho whose spectrum (1 - rho^2) / |1 - rho e^(i w)|^2 has this ratio between two bands."""
    if low <= 0 or high <= 0 or 0.5 < low / high < 2.0:
        return 0.0
    rho = np.linspace(-0.9, 0.95, 371)
    ratio = _shape(rho, centre("0.3_0.5")) / _shape(rho, centre("0.02_0.1"))
    return float(rho[np.argmin(np.abs(np.log(ratio) - math.log(low / high)))])


def _shape(rho: np.ndarray, frequency: float) -> np.ndarray:
    """|1 - rho e^(2 pi i f)|^2."""
    return 1.0 - 2.0 * rho * math.cos(2.0 * math.pi * frequency) + rho * rho
