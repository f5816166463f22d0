"""A few columns or rows with more or less dark charge than the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Site, Stage, parameter
from dnanalyze.model.effects.defect_lines import DefectLines


@dataclass(frozen=True)
class ScaledLines(DefectLines):
    """h (1 + s_j) on a fixed few lines; their number and the rms of s are exact."""

    name: ClassVar[str] = "scaled_lines"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    summary: ClassVar[str] = "single columns or rows with a multiple of the others' dark charge"
    physics: ClassVar[str] = (
        "A column whose pixels are disconnected, or whose charge is lost on its way, has no "
        "dark signal, and only the noise of the readout. Damage along a line, a missing "
        "implant or a misaligned mask makes the dark current of all its pixels several times "
        "that of the others. Such a line is invisible at low temperature and short exposure. "
        "Otherwise it deviates by a constant share of the dark signal, and its shot noise is "
        "that of its own charge. A line with a wrong offset deviates equally in all frames. A "
        "share of -1 is a line without dark charge; a line with a large share reaches the "
        "highest code. Remedy: a map of bad lines, made from warm frames; interpolation "
        "across them."
    )
    formula: ClassVar[str] = (
        "h_ij (1 + s_j), not below 0, on the lines named, each from its begin to its end, or on "
        "round(fraction x lines) whole lines; mean s^2 = sigma^2"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA 1288 release 4.0 (profiles)",
        "Janesick, Scientific Charge-Coupled Devices, SPIE Press (2001)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "column_outliers", "column_extreme", "row_outliers", "row_extreme", "column_kurtosis",
        "row_kurtosis",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "defect_lines": "a fixed offset stands out in cold and short frames as well",
        "column_gain": "all columns scatter, with a Gaussian distribution",
        "hot_clusters": "short runs of pixels, not whole lines",
    }

    sigma: float = parameter(
        0.8, "1", 1e-3, 1e3, "rms over these lines of their excess, as a share of the dark signal"
    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Scale the dark charge of the lines in the window."""
        share = self.pattern(site, self.value("sigma", site.point))
        signal *= np.maximum(np.float32(1.0) + share, np.float32(0.0))
        return signal

    def variance(self, point: OperatingPoint) -> float | None:
        """None: a share of a signal that is not known here."""
        return None
