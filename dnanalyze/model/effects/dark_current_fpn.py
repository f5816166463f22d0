"""Dark current that differs from pixel to pixel with less skewness than a log-normal law gives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter
from dnanalyze.model.gamma import gamma_deviates

LEFT = 0.3  # of the seed's standard deviation, 9 % of its variance: a fit can move it either way


@dataclass(frozen=True)
class DarkCurrentFpn(Effect):
    """h x, x of mean 1 and standard deviation rms, independent from pixel to pixel."""

    name: ClassVar[str] = "dark_current_fpn"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "dark current of the pixels with a normal or gamma distribution"
    physics: ClassVar[str] = (
        "The dark current of a pixel is the sum over its generation centers. Where each pixel "
        "has many of them, and of similar strength, the sum is nearly normal over the pixels "
        "(central limit theorem); where it has few, of exponential strengths, it follows a "
        "gamma distribution, whose skewness is twice the relative standard deviation. The "
        "log-normal seed of the Wang 2025 model has three times. The factor is the same in "
        "every frame, at every exposure and temperature. It is white over the field and does "
        "not change the mean dark signal. Remedies: subtract a dark frame scaled to exposure "
        "and temperature."
    )
    formula: ClassVar[str] = (
        "h x; normal: x = max(0, 1 + rms n), n ~ N(0, 1); gamma: x ~ Gamma(k, 1/k), k = 1/rms^2, "
        "skewness 2 rms; independent pixels, fixed in the silicon"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA Standard 1288, release 4.0 (DSNU)",
        "Janesick, Photon Transfer, SPIE Press (2007): dark current FPN",
        "Baer, A model for dark current characterization and simulation, SPIE 6068 (2006)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "pattern_q0.99",
        "pattern_q0.01",
        "pattern_q0.1",
        "pattern_q0.999",
        "pattern_q0.001",
        "excess_4",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "hot_pixels": "a population of hot pixels lengthens the upper tail alone",
        "pixel_fpn": "an offset does not grow with the dark signal",
        "dark_shading": "shading has its power at low spatial frequency",
    }

    rms: float = parameter(
        0.1, "1", 1e-3, 2.0, "standard deviation over the pixels, as a share of the dark signal"
    )
    law: str = choice("normal", "distribution over the pixels", "normal", "gamma")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Scale the dark charge."""
        signal *= site.keep("factor", lambda: self._factor(site))
        return signal

    def _factor(self, site: Site) -> np.ndarray:
        rms, normal = self.value("rms", site.point), site.fixed_normal()
        if self.law == "gamma":
            return gamma_deviates(normal, rms)
        return np.maximum(np.float32(1.0) + np.float32(rms) * normal, np.float32(0.0))

    def nuisance_bias(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """A log-normal seed alone takes its standard deviation for its own; its mean stays."""
        rms = self.rms if isinstance(self.rms, (int, float)) else 0.0
        if name == "convolved_lognormal.delta":
            return LEFT, 0.0
        if name.startswith("convolved_lognormal.mu"):
            return 1.0, 0.5 * (1.0 - LEFT**2) * math.log1p(rms**2)
        return 1.0, 0.0
