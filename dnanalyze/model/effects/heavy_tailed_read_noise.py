"""Read noise with tails heavier than Gaussian on both sides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import (
    HALF_THE_VARIANCE,
    Effect,
    Placing,
    Site,
    Stage,
    choice,
    parameter,
)
from dnanalyze.significance import CLEAR

QUARTILE = 0.6744898  # of the standard normal distribution
FAR, FAR_NORMAL = 0.999, 3.090232  # a quantile in the tail, and that of the normal distribution
# Its relative standard error of n normal deviates, times sqrt(n): sqrt(p (1 - p)) / (density x
# quantile)
FAR_ERROR = 3.04
# Least share of the variance of the Gaussian noise beside it, 0.3 of its deviation: from none at
# all no derivative leads back.
LEAST_GAUSSIAN = 0.3**2


@dataclass(frozen=True)
class HeavyTailedReadNoise(Effect):
    """y += sigma Q(p), Q the quantile function of Tukey's lambda or Student's t distribution,
    scaled to a Gaussian's quartiles.
    """

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
        "Student's t with 5 degrees of freedom (nu = -1/lambda); Student's t itself, where the "
        "variance of Gaussian noise differs from read to read (`form`), has the same far tails and "
        "a rounder core. It belongs to the readout: no "
        "growth with exposure, hardly any with temperature, and it follows the analog gain. It "
        "adds to read_noise. Remedy: multiple or correlated sampling, buried channel transistors; "
        "medians instead of means over frames."
    )
    formula: ClassVar[str] = (
        "y += sigma q(p) / s;  q(p) = (p^lambda - (1-p)^lambda) / lambda, s = q(0.75) / 0.6745, p "
        "uniform; or q(p) the quantile of Student's t with nu degrees of freedom"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Wei, Fu, Yang, Huang, A physics-based noise formation model for extreme low-light raw "
        "denoising (ELD), CVPR 2020 (Tukey-lambda)",
        "Student, Biometrika 6 (1908) 1 (t distribution: Gaussian of inverse-gamma variance)",
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
    form: str = choice("tukey", "distribution", "tukey", "student")
    freedom: float = parameter(
        5.0, "1", 2.1, 30.0, "degrees of freedom nu of Student's t; 30 is nearly Gaussian"
    )

    def inactive_parameters(self) -> tuple[str, ...]:
        """The number of the other distribution."""
        return ("tail",) if self.form == "student" else ("freedom",)

    def shows_in(self, frames: int, pixels: int) -> bool:
        """Whether so many deviates tell its tails from those of Gaussian noise."""
        if not isinstance(self.tail, float) or not isinstance(self.freedom, float):
            return True
        if self.form == "student":
            far = student_quantile(FAR, self.freedom) / student_scale(self.freedom)
        else:
            far = tukey_quantile(FAR, self.tail) / robust_scale(self.tail)
        return abs(far / FAR_NORMAL - 1.0) > CLEAR * FAR_ERROR / math.sqrt(frames * pixels)

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the noise: a Gaussian field bent into shape, so it moves smoothly with its tail."""
        sigma = self.value("sigma", site.point) * site.gain_ratio
        if self.form == "student":
            freedom = self.value("freedom", site.point)
            signal += np.float32(sigma / student_scale(freedom)) * student(site.normal(), freedom)
            return signal
        tail = self.value("tail", site.point)
        scale = self.value("sigma", site.point) * site.gain_ratio / robust_scale(tail)
        signal += np.float32(scale) * tukey_lambda(site.normal(), tail)
        return signal

    def nuisance_bias(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """A spread of sigma over pixels makes such a tail in the frame, Gaussian noise none.

        What is left of the Gaussian noise has the correlations of the sum.
        """
        left = self._gaussian_share(noise)
        factors = {
            "read_noise.spread": HALF_THE_VARIANCE,
            "read_noise.sigma": math.sqrt(left),
            "read_noise.serial": 1.0 / left,
            "read_noise.serial2": 1.0 / left,
        }
        return factors.get(name, 1.0), 0.0

    def _gaussian_share(self, noise: float) -> float:
        """Share of the variance of a noise, DN, that this one leaves."""
        known = all(isinstance(x, (int, float)) for x in (self.sigma, self.tail, self.freedom))
        if not known or not 0.0 < noise < math.inf:
            return LEAST_GAUSSIAN
        own = self._variance(self.sigma, self.tail, self.freedom)
        return max(LEAST_GAUSSIAN, 1.0 - own / noise**2)

    def variance(self, point: OperatingPoint) -> float:
        """Variance of the Tukey-lambda distribution, or nu / (nu - 2) of Student's t, DN^2."""
        return self._variance(*(self.value(n, point) for n in ("sigma", "tail", "freedom")))

    def _variance(self, sigma: float, tail: float, freedom: float) -> float:
        if self.form == "student":
            return (sigma / student_scale(freedom)) ** 2 * freedom / (freedom - 2.0)
        return (sigma / robust_scale(tail)) ** 2 * tukey_variance(tail)


def tukey_lambda(z: np.ndarray, tail: float) -> np.ndarray:
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


def student(z: np.ndarray, freedom: float) -> np.ndarray:
    """Standard normal deviates to Student's t deviates, by way of their probability."""
    from scipy.special import ndtr

    z = np.asarray(z, np.float64)
    size = _student_at(np.log(ndtr(-np.abs(z))), freedom)
    return np.copysign(size, z).astype(np.float32)


def student_quantile(p: float, freedom: float) -> float:
    """Quantile of Student's t distribution, p from 1/2 to 1."""
    return float(_student_at(np.array(math.log1p(-p)), freedom))


def student_scale(freedom: float) -> float:
    """Quartile of Student's t distribution over that of the standard normal."""
    return student_quantile(0.75, freedom) / QUARTILE


def _student_at(log_p: np.ndarray, freedom: float) -> np.ndarray:
    """Student's t deviate that a share p of all exceed, p up to 1/2; to 1e-5, or 1e-6 near 0."""
    y, minus_log = _student_table(float(freedom))
    return np.asarray(math.sqrt(freedom) * np.sinh(np.interp(-log_p, minus_log, y)))


@lru_cache(maxsize=64)
def _student_table(nu: float) -> tuple[np.ndarray, np.ndarray]:
    """y = asinh(t / sqrt(nu)) and minus the log of the probability beyond it.

    The density in y is c sqrt(nu) cosh(y)^-nu, c = G((nu + 1)/2) / (sqrt(nu pi) G(nu/2)). It is
    summed from the tail, where it is c sqrt(nu) (2 e^-y)^nu, by the trapezium rule with its end
    correction; to probabilities of 1e-11, below those of 32-bit deviates.
    """
    end = math.log(2.0) + 26.0 / nu
    y = np.linspace(0.0, end, 8192)
    constant = math.lgamma((nu + 1) / 2) - math.lgamma(nu / 2) - 0.5 * math.log(math.pi)
    density = np.exp(constant - nu * np.log(np.cosh(y)))
    step = y[1]
    slope = -nu * np.tanh(y) * density
    parts = step / 2 * (density[1:] + density[:-1]) - step**2 / 12 * (slope[1:] - slope[:-1])
    beyond = np.append(np.cumsum(parts[::-1])[::-1], 0.0) + density[-1] / nu
    return y, -np.log(beyond / beyond[0] / 2.0)


def tukey_quantile(p: float, tail: float) -> float:
    """Quantile of the Tukey-lambda distribution."""
    if abs(tail) < 1e-4:
        return math.log(p / (1.0 - p))
    return (p**tail - (1.0 - p) ** tail) / tail


def robust_scale(tail: float) -> float:
    """Quartile of the Tukey-lambda distribution over that of the standard normal."""
    return tukey_quantile(0.75, tail) / QUARTILE


def tukey_variance(tail: float) -> float:
    """Variance of the Tukey-lambda distribution, lambda > -1/2."""
    if abs(tail) < 1e-3:
        return math.pi**2 / 3.0
    beta = math.gamma(tail + 1.0) ** 2 / math.gamma(2.0 * tail + 2.0)
    return 2.0 / tail**2 * (1.0 / (1.0 + 2.0 * tail) - beta)
