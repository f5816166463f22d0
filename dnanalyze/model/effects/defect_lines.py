"""A few columns or rows far off the others."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter
from dnanalyze.model.evidence import bounded, excess, shows, typical_positive


@dataclass(frozen=True)
class DefectLines(Effect):
    """y += offset on a fixed few lines; their number and the rms of their offsets are exact."""

    name: ClassVar[str] = "defect_lines"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "Single columns or rows that stand out from all others."
    physics: ClassVar[str] = (
        "A leaking column line, a defect in a column's converter or a broken row driver shifts one "
        "whole line, many times further than lines scatter otherwise. In a CCD a trap or a bright "
        "defect that is clocked through makes a bright or dark column. The offset is fixed, "
        "commonly independent of exposure, and follows the analogue gain. Cure: a map of bad "
        "lines; interpolation across them."
    )
    formula: ClassVar[str] = "y_ij += o_j on round(fraction x lines) lines;  mean o^2 = sigma^2"
    references: ClassVar[tuple[str, ...]] = ("EMVA 1288 release 4.0 (profiles)",)
    fingerprint: ClassVar[tuple[str, ...]] = (
        "column_outliers", "column_extreme", "row_outliers", "row_extreme", "column_kurtosis",
        "row_kurtosis",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "column_fpn": "all columns scatter, with a Gaussian distribution",
        "row_fpn": "all rows scatter, with a Gaussian distribution",
        "column_taps": "a regular period, or wide strips",
        "hot_clusters": "short runs of pixels, not whole lines",
    }

    fraction: float = parameter(0.005, "1", 1e-5, 0.2, "share of lines")
    sigma: float = parameter(3.0, "DN", 1e-3, 1e4, "rms of their offsets")
    axis: str = choice("columns", "which lines", "columns", "rows")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offsets of the lines in the window."""
        by_column = self.axis == "columns"
        lines = site.shape[1] if by_column else site.shape[0]
        whole = Window(0, 1, 0, lines)
        place = site.silicon.child("place").uniform(whole, lines)[0]
        count = round(self.value("fraction", site.point) * lines)
        chosen = np.argsort(place, kind="stable")[:count]
        if not chosen.size:
            return signal
        size = site.silicon.child("size").normal(whole, lines)[0][chosen]
        offsets = np.zeros(lines, np.float32)
        offsets[chosen] = size / np.sqrt(np.mean(size**2))
        offsets *= np.float32(self.value("sigma", site.point) * site.gain_ratio)
        signal += offsets[site.column_index] if by_column else offsets[site.row_index][:, None]
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """fraction sigma^2, DN^2."""
        return self.value("fraction", point) * self.value("sigma", point) ** 2

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """Share from the count of outlying lines, offset from the farthest one."""
        found: list[Effect] = []
        for axis, line, across in (("columns", "column", 1), ("rows", "row", 0)):
            if not shows(clues, [f"{line}_{k}" for k in ("outliers", "extreme", "kurtosis")]):
                continue
            lines, length = clues.shape[across], clues.shape[1 - across]
            count = max(1.0, typical_positive(excess(clues, f"{line}_outliers")))
            farthest = typical_positive(np.asarray(clues.measured(f"{line}_extreme"), float))
            power = np.asarray(clues.simulated(f"pattern_{axis}_0.3_0.5"), float)
            spread = math.sqrt(typical_positive(power) / length) or 1.0
            beyond = math.sqrt(1.0 + 2.0 * math.log(count))  # of the largest of so many Gaussians
            sigma = bounded(cls, "sigma", farthest * spread / beyond)
            found.append(cls(bounded(cls, "fraction", count / lines), sigma, axis))
        return found
