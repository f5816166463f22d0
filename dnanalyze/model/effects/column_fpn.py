"""Fixed offsets of the columns."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Placing, Site, Stage, choice, parameter
from dnanalyze.model.fingerprints import LINE_BANDS, named
from dnanalyze.model.readout_effect import ADDED, ReadoutEffect
from dnanalyze.model.streams import Stream


@dataclass(frozen=True)
class ColumnFpn(ReadoutEffect):
    """y += c_j + a e^(-j/l) + b e^(-k/m); c_j = rho c_(j-1) + sqrt(1 - rho^2) sigma n_j."""

    name: ClassVar[str] = "column_fpn"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "Fixed vertical stripes: every column has its own offset."
    physics: ClassVar[str] = (
        "In a CMOS sensor all pixels of a column share one amplifier and one converter, whose "
        "offsets differ from column to column. The stripes are the same in every frame. They "
        "do not grow with temperature or exposure, because they arise after the pixel. They "
        "are proportional to the analog gain where the offset arises before the gain stage. "
        "Neighbouring columns that share bias lines have similar offsets (rho > 0); column "
        "pairs that share a circuit may alternate (rho < 0). A CCD reads all columns through "
        "one amplifier, whose level settles after each line transfer: the columns that are "
        "read first deviate from the others, and the deviation decays exponentially "
        "(`settle`, `length`). The columns at the other edge of the array may deviate too "
        "(`edge`, `edge_length`), by charge from outside the array or the end of the line. "
        "Remedy: subtract the column means of optically black rows, or of a master dark; "
        "correlated double sampling in the column circuit or digital in the converter."
    )
    formula: ClassVar[str] = (
        "y_ij += c_j + a e^(-j/l) + b e^(-k/m), j from the column that is read first, k from the "
        "last;  "
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
        "defect_lines": "a few columns far off the others, not a normal distribution of all",
        "dark_gradient": "power below 0.02 cycles/pixel alone, in rows too, that grows with "
        "exposure",
    }

    sigma: float = parameter(0.5, "DN", 1e-4, 1e3, "standard deviation of the column offsets")
    rho: float = parameter(0.0, "1", -0.95, 0.99, "correlation of neighbouring columns", "linear")
    settle: float = parameter(
        0.0, "DN", -1e4, 1e4, "offset a of the first column where the level settles", "linear"
    )
    length: float = parameter(50.0, "column", 1.0, 1e4, "columns l over which it settles by e")
    first: str = choice("left", "side that is read first", "left", "right")
    edge: float = parameter(
        0.0, "DN", -1e4, 1e4, "offset b of the last column, beside an edge of the array", "linear"
    )
    edge_length: float = parameter(50.0, "column", 1.0, 1e4, "columns m over which it falls by e")
    added: str = choice("before", ADDED, "before", "after")

    def inactive_parameters(self) -> tuple[str, ...]:
        """The transients where there are none."""
        settled = ("settle", "length") if self.settle == 0.0 else ()
        return (*settled, *(("edge", "edge_length") if self.edge == 0.0 else ()))

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offsets."""
        sigma = self.value("sigma", site.point) * self.amplified(site)
        signal += np.float32(sigma) * self._offsets(site)
        if self.settle != 0.0 or self.edge != 0.0:
            line = self._transients(site.point, site.shape)
            line = line if self.first == "left" else line[::-1]
            signal += np.float32(self.amplified(site)) * line[site.column_index].astype(np.float32)
        return signal

    def _offsets(self, site: Site) -> np.ndarray:
        """Unit offsets of the window's columns; the recursion runs over the whole row."""
        rho = self.value("rho", site.point)
        stream = site.fixed_stream.child("columns")
        if rho == 0.0:
            return site.columns(stream)
        return site.keep("offsets", lambda: _autoregressive(stream, site, rho))

    def black_shift(
        self, point: OperatingPoint, reference: OperatingPoint, shape: tuple[int, int]
    ) -> float:
        """Median of the transients."""
        return self.amplification(point, reference) * float(
            np.median(self._transients(point, shape))
        )

    def adds(
        self, point: OperatingPoint, reference: OperatingPoint, shape: tuple[int, int]
    ) -> tuple[float, float]:
        """No charge, and the variance of the columns with their transients."""
        variance = self.variance(point) + float(np.var(self._transients(point, shape)))
        return 0.0, self.amplification(point, reference) ** 2 * variance

    def _transients(self, point: OperatingPoint, shape: tuple[int, int]) -> np.ndarray:
        """Transients of all columns at the reference gain, DN, the column read first at first."""
        order = np.arange(shape[1])
        height, length, edge, edge_length = (
            self.value(name, point) for name in ("settle", "length", "edge", "edge_length")
        )
        return np.asarray(
            height * np.exp(-order / length) + edge * np.exp(-order[::-1] / edge_length)
        )

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2; a transient adds a^2 l / (2 columns), for l far below the columns."""
        return self.value("sigma", point) ** 2


def _autoregressive(stream: Stream, site: Site, rho: float) -> np.ndarray:
    """First-order autoregressive line of unit variance over all columns, cut to the window."""
    from scipy.signal import lfilter

    width = site.shape[1]
    white = stream.normal(Window(0, 1, 0, width), width)[0].astype(float)
    white[1:] *= math.sqrt(1.0 - rho * rho)
    line = lfilter([1.0], [1.0, -rho], white)
    return line[site.window.left : site.window.right].astype(np.float32)
