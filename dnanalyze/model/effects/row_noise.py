"""Offsets of the rows, new in every frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter
from dnanalyze.model.fingerprints import LINE_BANDS, named


@dataclass(frozen=True)
class RowNoise(Effect):
    """y += r_i of the frame."""

    name: ClassVar[str] = "row_noise"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "Horizontal stripes that change in every frame (banding)."
    physics: ClassVar[str] = (
        "All pixels of a row are sampled at the same instant. A disturbance of the supply, "
        "the ramp or the reference at that instant shifts the whole row; the next row has "
        "another value. It is visible to the eye at a tenth of the pixel noise. It does not "
        "grow with temperature or exposure and follows the analog gain. Averaging K frames "
        "lowers its power K times. Remedy: subtract the mean of the row's n optically black "
        "pixels, which leaves 1/n of their noise; quieter supplies."
    )
    formula: ClassVar[str] = "y_ij += r_i;  r_i ~ N(0, sigma^2), new in every frame"
    references: ClassVar[tuple[str, ...]] = (
        "Wei, Fu, Yang, Huang, A physics-based noise formation model for extreme low-light raw "
        "denoising (ELD), CVPR 2020",
    )
    fingerprint: ClassVar[tuple[str, ...]] = named("temporal_rows", reversed(LINE_BANDS))
    confused_with: ClassVar[dict[str, str]] = {
        "row_fpn": "the same stripes in every frame: they cancel in differences of frames",
        "flicker_noise": "neighbouring rows are correlated (temporal_row_lag1 > 0), and the noise "
        "is also smooth along the row",
        "periodic_pattern": "one line in the spectrum, not all frequencies",
    }

    sigma: float = parameter(0.3, "DN", 1e-4, 1e3, "standard deviation of the row offsets")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offsets."""
        sigma = self.value("sigma", site.point) * site.gain_ratio
        signal += np.float32(sigma) * site.rows(site.frame_stream.child("rows"))[:, None]
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2."""
        return self.value("sigma", point) ** 2
