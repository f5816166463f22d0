"""Read noise with tails heavier than Gaussian on both sides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter

QUARTILE = 0.6744898  # of the standard normal distribution


@dataclass(frozen=True)
class HeavyTailedReadNoise(Effect):
    """y += sigma Q(p), Q the Tukey-lambda quantile function scaled to a Gaussian's quartiles."""

    name: ClassVar[str] = "heavy_tailed_read_noise"
    stage: ClassVar[Stage] = Stage.PIXEL_READ
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = (
        "Read noise with more large deviations, up and down, than a normal distribution has."
    )
    physics: ClassVar[str] = (
        "The read noise of a CMOS sensor is a mixture: most pixels are quiet, some have a trap in "
        "the source follower whose switching, or whose 1/f noise, is many times larger. Over the "
        "whole frame the noise then has symmetric heavy tails, described by the Tukey-lambda "
        "distribution: lambda = 0.14 is nearly Gaussian, 0 is logistic, −0.2 has tails like "
        "Student's t with 5 degrees of freedom (nu = -1/lambda). It belongs to the readout: no "
        "growth with exposure, hardly any with temperature, and it follows the analog gain. It "
        "adds to read_noise. Remedy: multiple or correlated sampling, buried channel transistors; "
        "medians instead of means over frames."
    )
    formula: ClassVar[str] = (
        "y += sigma q(p) / s;  q(p) = (p^lambda - (1-p)^lambda) / lambda, s = q(0.75) / 0.6745, p "
        "uniform"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Wei, Fu, Yang, Huang, A physics-based noise formation model for extreme low-light raw "
        "denoising (ELD), CVPR 2020 (Tukey-lambda)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_kurtosis", "temporal_q0.999", "temporal_q0.001", "temporal_q0.99",
        "temporal_q0.01", "transient_high", "transient_low",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "rts": "two levels in a few pixels, growing with temperature and exposure: the same "
        "pixels are noisy in every pair of frames (blink_repeat)",
        "noisy_pixels": "the same pixels are noisy in every frame (blink_repeat)",
        "cosmic_rays": "upward only, in clusters, growing with exposure",
        "dark_shot_noise": "noisier in brighter pixels; the cold frames stay Gaussian",
        "hot_pixels": "vanish in differences of frames but for their shot noise",
    }

    sigma: float = parameter(
        1.0, "DN", 1e-4, 1e4, "robust standard deviation (quartiles) at the reference gain"
    )
    tail: float = parameter(
        -0.15, "1", -0.45, 0.14, "lambda: 0.14 Gaussian, 0 logistic, -1/nu Student's t", "linear"
    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the noise: a Gaussian field bent into shape, so it moves smoothly with ``tail``."""
        tail = self.value("tail", site.point)
        scale = self.value("sigma", site.point) * site.gain_ratio / robust_scale(tail)
        signal += np.float32(scale) * bent(site.normal(), tail)
        return signal

    def bent(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """A spread of sigma over pixels makes such a tail in the frame, Gaussian noise none."""
        return {"read_noise.spread": 0.0, "read_noise.sigma": 0.3}.get(name, 1.0), 0.0

    def variance(self, point: OperatingPoint) -> float:
        """Variance of the Tukey-lambda distribution, DN^2."""
        tail = self.value("tail", point)
        return (self.value("sigma", point) / robust_scale(tail)) ** 2 * tukey_variance(tail)


def bent(z: np.ndarray, tail: float) -> np.ndarray:
    """Standard normal deviates to Tukey-lambda deviates, by way of their probability.

    In double precision: NumPy's exponentials differ by the last bit from processor to processor,
    which the result in single precision does not show.
    """
    from scipy.special import ndtr

    z = np.asarray(z, np.float64)
    p = ndtr(-np.abs(z))  # the small side: exact far into the tail
    far, near = np.log(p), np.log1p(-p)
    if abs(tail) < 1e-4:
        size = near - far
    else:
        size = (np.exp(tail * near) - np.exp(tail * far)) / tail
    return np.copysign(size, z).astype(np.float32)


def robust_scale(tail: float) -> float:
    """Quartile of the Tukey-lambda distribution over that of the standard normal."""
    if abs(tail) < 1e-4:
        return math.log(3.0) / QUARTILE
    return (0.75**tail - 0.25**tail) / tail / QUARTILE


def tukey_variance(tail: float) -> float:
    """Variance of the Tukey-lambda distribution, lambda > -1/2."""
    if abs(tail) < 1e-3:
        return math.pi**2 / 3.0
    beta = math.gamma(tail + 1.0) ** 2 / math.gamma(2.0 * tail + 2.0)
    return 2.0 / tail**2 * (1.0 / (1.0 + 2.0 * tail) - beta)
