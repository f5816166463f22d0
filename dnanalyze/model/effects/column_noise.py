"""Offsets of the columns, new in every frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Placing, Site, Stage, choice, parameter
from dnanalyze.model.fingerprints import LINE_BANDS, named
from dnanalyze.model.readout_effect import ADDED, ReadoutEffect


@dataclass(frozen=True)
class ColumnNoise(ReadoutEffect):
    """y += c_j of the frame."""

    name: ClassVar[str] = "column_noise"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "Vertical stripes that change in every frame."
    physics: ClassVar[str] = (
        "The offset of a column circuit is set once a frame where its clamp or its auto-zero is "
        "refreshed at the start of the frame: the sampled noise stays for the frame and is drawn "
        "anew in the next. Rotated readouts, where a physical row lies along the image's columns, "
        "show row noise in this way. It does not grow with temperature or exposure and follows the "
        "analog gain. Averaging K frames lowers its power K times. Remedy: subtract the column "
        "means of optically black rows of the same frame; a master dark does not help."
    )
    formula: ClassVar[str] = "y_ij += c_j;  c_j ~ N(0, sigma^2), new in every frame"
    references: ClassVar[tuple[str, ...]] = ()
    fingerprint: ClassVar[tuple[str, ...]] = named("temporal_columns", reversed(LINE_BANDS))
    confused_with: ClassVar[dict[str, str]] = {
        "column_fpn": "the same stripes in every frame: they cancel in differences of frames",
        "periodic_pattern": "one line in the spectrum, not all frequencies",
    }

    sigma: float = parameter(0.3, "DN", 1e-4, 1e3, "standard deviation of the column offsets")
    added: str = choice("before", ADDED, "before", "after")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the offsets."""
        sigma = self.value("sigma", site.point) * self.amplified(site)
        signal += np.float32(sigma) * site.columns(site.frame_stream.child("columns"))
        return signal

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2."""
        return self.value("sigma", point) ** 2
