"""White Gaussian noise of the readout, new in every frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Site, Stage, parameter


@dataclass(frozen=True)
class ReadNoise(Effect):
    """y += sigma N(0,1), independent over pixels and frames."""

    name: ClassVar[str] = "read_noise"
    stage: ClassVar[Stage] = Stage.PIXEL_READ
    varies: ClassVar[str] = "temporal"
    fingerprint: ClassVar[tuple[str, ...]] = ("temporal_noise",)

    sigma: float = parameter(1.0, "DN", 1e-3, 1e4, "standard deviation at the reference gain")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the noise."""
        return signal + np.float32(self.value("sigma", site.point) * site.gain_ratio) * site.normal()

    def variance(self, point: OperatingPoint) -> float:
        """sigma^2, DN^2."""
        return self.value("sigma", point) ** 2
