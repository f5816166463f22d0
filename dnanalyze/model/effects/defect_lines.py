"""A few columns or rows far off the others."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter


@dataclass(frozen=True)
class DefectLines(Effect):
    """y += offset on a fixed few lines; their number and the rms of their offsets are exact."""

    name: ClassVar[str] = "defect_lines"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "Single columns or rows that stand out from all others."
    physics: ClassVar[str] = (
        "A leaking column line, a defect in a column's converter or a broken row driver "
        "shifts one whole line by many times the standard deviation of the other lines. In a "
        "CCD a trap or a bright defect that is clocked through makes a bright or dark column, "
        "from its own row on. The offset is fixed, commonly independent of exposure, and "
        "follows the analog gain. Remedy: a map of bad lines; interpolation across them."
    )
    formula: ClassVar[str] = (
        "y_ij += o_j on the lines named, each from its begin to its end, or on round(fraction x "
        "lines) whole lines;  mean o^2 = sigma^2"
    )
    references: ClassVar[tuple[str, ...]] = ("EMVA 1288 release 4.0 (profiles)",)
    fingerprint: ClassVar[tuple[str, ...]] = (
        "column_outliers", "column_extreme", "row_outliers", "row_extreme", "column_kurtosis",
        "row_kurtosis",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "column_fpn": "all columns scatter, with a Gaussian distribution",
        "row_fpn": "all rows scatter, with a Gaussian distribution",
        "column_taps": "a regular period, or wide strips",
        "scaled_lines": "lines whose dark charge is scaled: their offset grows with exposure and "
        "temperature",
        "stuck_pixels": "a saturated line stands at one code, without noise",
        "hot_clusters": "short runs of pixels, not whole lines",
    }

    fraction: float = parameter(0.005, "1", 1e-5, 0.2, "share of lines")
    sigma: float = parameter(3.0, "DN", 1e-3, 1e4, "rms of their offsets")
    axis: str = choice("columns", "which lines", "columns", "rows")
    lines: tuple[float, ...] = choice(
        (), "numbers of the lines, as measured; if empty, lines at random positions"
    )
    offsets: tuple[float, ...] = choice(
        (), ("relative size of the deviation of each line, in the order of lines")
    )
    begins: tuple[float, ...] = choice(
        (), ("first pixel of each defective part; if empty, the first of the line")
    )
    ends: tuple[float, ...] = choice(
        (), ("pixel after each defective part; if empty, the end of the line")
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, value in (("begins", self.begins), ("ends", self.ends)):
            if value and len(value) != len(self.lines):
                raise InputError(
                    f"{self.name}.{name}: {len(value)} numbers for {len(self.lines)} lines; give "
                    "one a line, or none"
                )
        if len(self.lines) != len(self.offsets) or (self.offsets and not any(self.offsets)):
            raise InputError(
                f"{self.name}.offsets: {len(self.offsets)} numbers for {len(self.lines)} lines; "
                "give one a line, not all 0"
            )

    def inactive_parameters(self) -> tuple[str, ...]:
        """The share, where the lines are named."""
        return ("fraction",) if self.lines else ()

    def lies_in(self, window: Window) -> bool:
        """Whether a named line crosses the window."""
        down, right = (window.top, window.bottom), (window.left, window.right)
        (first, last), (near, far) = (right, down) if self.axis == "columns" else (down, right)
        begins = self.begins or (0.0,) * len(self.lines)
        ends = self.ends or (math.inf,) * len(self.lines)
        return not self.lines or any(
            first <= line < last and begin < far and end > near
            for line, begin, end in zip(self.lines, begins, ends, strict=True)
        )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offsets of the lines in the window."""
        signal += self.pattern(site, self.value("sigma", site.point) * site.gain_ratio)
        return signal

    def pattern(self, site: Site, rms: float) -> np.ndarray:
        """What the lines add in the window, float32; rms over the lines as given.

        Parameters
        ----------
        site : Site
        rms : float
            In the unit of the result.

        Returns
        -------
        ndarray
            Of a shape that spreads over (rows, columns).
        """
        size = np.float32(rms)
        if self.begins or self.ends:
            return np.asarray(size * site.keep("parts", lambda: self._parts(site)))
        by_column = self.axis == "columns"
        offsets = size * (self._named(site) if self.lines else self._drawn(site))
        return offsets[site.column_index] if by_column else offsets[site.row_index][:, None]

    def _relative(self) -> np.ndarray:
        """Offset of each named line; rms 1."""
        size = np.array(self.offsets, np.float32)
        return np.asarray(size / np.sqrt(np.mean(size**2)))

    def _named(self, site: Site) -> np.ndarray:
        """Relative offsets of all lines of the frame; lines beyond it are left out."""
        offsets = np.zeros(site.shape[1 if self.axis == "columns" else 0], np.float32)
        place = np.array(self.lines, int)
        inside = (place >= 0) & (place < offsets.size)
        offsets[place[inside]] = self._relative()[inside]
        return offsets

    def _parts(self, site: Site) -> np.ndarray:
        """Relative offsets of the pixels of the window, where each line is off from its begin to
        its end.
        """
        by_column = self.axis == "columns"
        across, along = site.row_index, site.column_index
        if by_column:
            across, along = along, across
        begins = np.array(self.begins or np.zeros(len(self.lines)))
        ends = np.array(self.ends or np.full(len(self.lines), np.inf))
        where = (along[:, None] >= begins) & (along[:, None] < ends)
        which = np.array(self.lines, int)[:, None] == across
        image = (where * self._relative()) @ which.astype(np.float32)
        return np.asarray(image if by_column else image.T, np.float32)

    def _drawn(self, site: Site) -> np.ndarray:
        lines = site.shape[1 if self.axis == "columns" else 0]
        whole = Window(0, 1, 0, lines)
        place = site.fixed_stream.child("place").uniform(whole, lines)[0]
        count = round(self.value("fraction", site.point) * lines)
        chosen = np.argsort(place, kind="stable")[:count]
        offsets = np.zeros(lines, np.float32)
        if chosen.size:
            size = site.fixed_stream.child("size").normal(whole, lines)[0][chosen]
            offsets[chosen] = size / np.sqrt(np.mean(size**2))
        return offsets

    def variance(self, point: OperatingPoint) -> float | None:
        """fraction sigma^2, DN^2; None where lines are named, whose share hangs on the frame."""
        if self.lines:
            return None
        return self.value("fraction", point) * self.value("sigma", point) ** 2
