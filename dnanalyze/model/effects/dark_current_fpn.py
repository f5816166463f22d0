"""Dark current that differs from pixel to pixel by another law than a log-normal one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter
from dnanalyze.model.gamma import gamma_deviates

LARGEST = 2.0  # relative standard deviation to which `gamma_deviates` is accurate
LEFT = 0.3  # of the seed's standard deviation, 9 % of its variance: a fit can move it either way


@dataclass(frozen=True)
class DarkCurrentFpn(Effect):
    """h x, x of mean 1 and standard deviation r(T), independent from pixel to pixel."""

    name: ClassVar[str] = "dark_current_fpn"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = (
        "dark current of the pixels with a normal, gamma or exponential distribution"
    )
    physics: ClassVar[str] = (
        "The dark current of a pixel is the sum over its generation centers. Where each pixel "
        "has many of them, and of similar strength, the sum is nearly normal over the pixels "
        "(central limit theorem); where it has few, of exponential strengths, it follows a "
        "gamma distribution, whose skewness is twice the relative standard deviation. The "
        "log-normal seed of the Wang 2025 model has three times. Where it has a single defect "
        "of exponential strength, as displacement damage leaves them, and diffusion from the "
        "neutral bulk, which is the same in all pixels, the distribution is exponential beyond "
        "a minimum. The factor is the same in every frame and at every exposure. Generation in "
        "depleted silicon has about half of the activation energy of diffusion, so that the "
        "relative standard deviation falls as such a sensor warms (`ea_ev` below 0). It is "
        "white over the field and does not change the mean dark signal. Remedies: subtract a "
        "dark frame of the same exposure and temperature."
    )
    formula: ClassVar[str] = (
        "h x, r = rms e^(-Ea/k (1/T - 1/T_ref)); normal: x = max(0, 1 + r n), n ~ N(0, 1); gamma: "
        "x ~ Gamma(k, 1/k), k = 1/r^2, skewness 2 r; exponential: x = 1 + r (e - 1), e ~ Exp(1), "
        "r <= 1, skewness 2; independent pixels, fixed in the silicon"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA Standard 1288, release 4.0 (DSNU)",
        "Janesick, Photon Transfer, SPIE Press (2007): dark current FPN",
        "Baer, A model for dark current characterization and simulation, SPIE 6068 (2006)",
        "Virmontois et al., IEEE Trans. Nucl. Sci. 59, 918 (2012) (exponential dark current)",
        "Widenhorn et al., SPIE 4669, 193 (2002) (diffusion and generation in pixels of a CCD)",
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
        0.1,
        "1",
        1e-3,
        LARGEST,
        "standard deviation over the pixels at the reference temperature, as a share of the dark "
        "signal",
    )
    law: str = choice("normal", "distribution over the pixels", "normal", "gamma", "exponential")
    ea_ev: float = parameter(
        0.0,
        "eV",
        -1.0,
        1.0,
        "activation energy of the differences between pixels less that of the mean dark signal",
        "linear",
    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Scale the dark charge."""
        signal *= site.keep("factor", lambda: self._factor(site))
        return signal

    def _factor(self, site: Site) -> np.ndarray:
        growth = site.thermal(self.value("ea_ev", site.point))
        rms = min(self.value("rms", site.point) * growth, LARGEST)
        normal = site.fixed_normal()
        if self.law == "normal":
            return np.maximum(np.float32(1.0) + np.float32(rms) * normal, np.float32(0.0))
        if self.law == "gamma":
            return gamma_deviates(normal, rms)
        rms = min(rms, 1.0)
        exponential = gamma_deviates(normal, 1.0)  # of shape 1
        return np.float32(1.0 - rms) + np.float32(rms) * exponential

    def nuisance_bias(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """A log-normal seed alone takes its standard deviation for its own; its mean stays.

        Of an exponential law the median stays, from which it is farther.
        """
        rms = self.rms if isinstance(self.rms, (int, float)) else 0.0
        if name == "convolved_lognormal.delta":
            return LEFT, 0.0
        if not name.startswith("convolved_lognormal.mu"):
            return 1.0, 0.0
        if self.law == "exponential":
            return 1.0, -math.log1p(min(rms, 1.0) * (math.log(2.0) - 1.0))
        return 1.0, 0.5 * (1.0 - LEFT**2) * math.log1p(rms**2)
