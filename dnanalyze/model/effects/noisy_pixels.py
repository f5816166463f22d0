"""A few pixels with more Gaussian read noise than the others."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import HALF_THE_VARIANCE, Effect, Placing, Site, Stage, parameter


@dataclass(frozen=True)
class NoisyPixels(Effect):
    """y += sigma N(0,1) in a fixed fraction of the pixels, new in every frame."""

    name: ClassVar[str] = "noisy_pixels"
    stage: ClassVar[Stage] = Stage.PIXEL_READ
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = "A fraction of the pixels has more Gaussian read noise than the rest."
    physics: ClassVar[str] = (
        "Many traps in the channel of a source follower, a leaky transistor or a weak contact "
        "make some pixels noisier than the others by the same amount: these pixels form a "
        "second population. In each of them the noise is Gaussian and independent from frame "
        "to frame. A telegraph signal has two levels instead and is correlated in time. The "
        "noise arises in the readout: it is the same at every exposure and temperature, and "
        "is proportional to the analog gain. Pixels that share an amplifier are noisy together "
        "(`shared` of `read_noise`). The quantiles of the temporal variance over "
        "pixels show the population; the mean frame hardly does. If the other pixels have the "
        "read noise s, these have sqrt(1 + sigma^2 / s^2) times as much. Remedy: a map of "
        "noisy pixels, averages over frames."
    )
    formula: ClassVar[str] = (
        "y_i += sigma N(0,1) where u_i < fraction, u_i uniform and fixed; variance over the "
        "frame fraction sigma^2"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA Standard 1288, release 4.0 (defect pixels by temporal noise)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_variance_q0.99",
        "temporal_variance_q0.999",
        "temporal_kurtosis",
        "blink_repeat",
        "temporal_variance_q0.9",
        "temporal_q0.999",
        "temporal_q0.001",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "rts": (
            "a telegraph signal has two levels, no values far beyond them, and is correlated in "
            "time"
        ),
        "heavy_tailed_read_noise": "heavy tails in every pixel: the same pixels are no noisier in "
        "the second half of the frames (blink_repeat)",
        "read_noise": "where sigma differs from pixel to pixel by a log-normal factor, there is "
        "no second population",
    }

    fraction: float = parameter(0.02, "1", 1e-4, 0.5, "fraction of the pixels")
    sigma: float = parameter(
        5.0, "DN", 1e-3, 1e4, "standard deviation that is added in them, at the reference gain"
    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the noise of the few."""
        signal += site.keep("map", lambda: self._map(site)) * site.normal()
        return signal

    def _map(self, site: Site) -> np.ndarray:
        sigma = np.float32(self.value("sigma", site.point) * site.gain_ratio)
        chosen = site.amplifiers("uniform", "place") < np.float32(
            self.value("fraction", site.point)
        )
        return sigma * chosen.astype(np.float32)

    def nuisance_bias(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """A fit without them has the read noise of all pixels higher, and unlike."""
        if name == "read_noise.spread":
            return HALF_THE_VARIANCE, 0.0
        if name == "read_noise.sigma" and isinstance(self.sigma, (int, float)):
            share = float(self.fraction) * self.sigma**2 / noise**2
            return math.sqrt(max(1.0 - share, 0.25)), 0.0
        return 1.0, 0.0

    def variance(self, point: OperatingPoint) -> float:
        """fraction sigma^2, DN^2."""
        return self.value("fraction", point) * self.value("sigma", point) ** 2
