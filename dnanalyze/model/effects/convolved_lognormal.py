"""The Wang 2025 model: a log-normal seed under a 3x3 kernel that is random at every pixel."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model import draws
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter


@dataclass(frozen=True)
class ConvolvedLognormal(Effect):
    """f ~ N(mu, delta^2), L = exp f; h = sum (K + eps) L, eps ~ N(0, sigma^2), each pixel and tap.

    Given L, the random part is exactly sigma sqrt(sum L^2) N(0,1): one normal a pixel, not nine.
    """

    name: ClassVar[str] = "convolved_lognormal"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "both"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = (
        "the Wang 2025 model: log-normal dark current under a random 3x3 kernel"
    )
    physics: ClassVar[str] = (
        "The logarithm of the dark current is nearly normal over the pixels, since many "
        "independent factors multiply in it: fields, distances, numbers of defects. mu is its "
        "mean (the level), delta its standard deviation (the skewness and the tail of warm "
        "pixels). Each pixel passes the share phi to each of its 8 neighbours, and the "
        "weights of the 3x3 kernel are random at every pixel and frame with standard "
        "deviation sigma, which makes a noise that grows with the signal. With a fixed seed "
        "the pattern is the same in every frame, as in real sensors; with a redrawn seed, "
        "another reading of the formula of Wang 2025, hot pixels change position. mu follows "
        "temperature through the dark current's activation energy (about 0.6 to 1.2 eV: a "
        "doubling every 5 to 9 °C). delta may follow temperature too, with a negative energy "
        "(delta: {value, at_c, ea_ev}): diffusion current is equal in all pixels and grows as "
        "n_i^2, generation in depleted silicon differs from pixel to pixel and grows as n_i, "
        "so that the relative standard deviation falls as the sensor warms, by 0 to −0.6 eV. "
        "diagnose and refine fit that energy only where the captures determine it. The "
        "spectrum falls from a plateau at low frequency: this model alone has no 1/f noise. "
        "Cool, or shorten the exposure, to reduce it."
    )
    formula: ClassVar[str] = (
        "h = sum over 3x3 of (K + eps) L, K = phi, centre 1 - 8 phi; mean m1 = e^(mu + "
        "delta^2/2); variance V (1 - 16 phi + 72 phi^2) + 9 sigma^2 m2, V = m1^2 (q - 1), m2 = "
        "m1^2 q, q = e^(delta^2); PSD V |K(u,v)|^2 + 9 sigma^2 m2, K(u,v) = 1 - 9 phi + phi (1 + "
        "2 cos 2 pi u)(1 + 2 cos 2 pi v)"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Wang, Funatsu and Fowler (Wang 2025)",
        "Baer, SPIE 6068 (2006)",
        "Widenhorn, Blouke, Weber, Rest and Bodegom, SPIE 4669 (2002): temperature of CCD dark "
        "current",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "mean",
        "pattern_noise_core",
        "pattern_q0.99",
        "pattern_q0.1",
        "noise_at_99",
        "pattern_corr_11",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "hot_pixels": (
            "a log-normal tail bends on a semilog plot; an exponential population is straight"
        ),
        "crosstalk": "crosstalk distributes the shot noise too; the kernel only the fixed pattern",
        "dark_shot_noise": (
            "shot variance is proportional to the signal, the kernel's to its square"
        ),
    }
    reach: ClassVar[int] = 1

    mu: float = parameter(
        0.0,
        "ln DN",
        -20.0,
        12.0,
        "mean of the log of the seed; a table may state it per gain",
        "linear",
    )
    delta: float = parameter(
        0.5, "ln DN", 1e-4, 4.0, "standard deviation of the log of the seed; may have an energy"
    )
    phi: float = parameter(
        1e-3, "1", 0.0, 0.125, "kernel weight of each of the 8 neighbours", "linear"
    )
    sigma: float = parameter(0.01, "1", 1e-6, 1e6, "standard deviation of each random kernel tap")
    seed: str = choice("fixed", "seed in the silicon, or redrawn each frame", "fixed", "redrawn")
    exposure: str = choice("proportional", "signal over exposure", "proportional", "none")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the convolved seed to the signal."""
        taps = site.frame_stream.child("kernel").key
        mu, delta, phi, sigma = self._numbers(site)
        if self.seed == "fixed":
            key = site.fixed_stream.child("seed").key
            mean, norm = site.keep(
                "seed", lambda: draws.lognormal(key, mu, delta, phi, site.window, site.shape[1])
            )
            return draws.add_scaled_normal(
                signal, mean, norm, sigma, taps, site.window, site.shape[1]
            )
        key = site.frame_stream.child("seed").key
        return draws.add_lognormal(
            signal, mu, delta, phi, sigma, (key, taps), site.window, site.shape[1]
        )

    def _numbers(self, site: Site) -> tuple[float, float, float, float]:
        """mu (with the exposure), delta, phi, sigma here."""
        mu, delta, phi, sigma = (self.value(n, site.point) for n in ("mu", "delta", "phi", "sigma"))
        if self.exposure == "proportional":
            mu += math.log(max(site.exposure_ratio, 1e-30))
        return mu, delta, phi, sigma

    def variance(self, point: OperatingPoint) -> float:
        """V (1 - 16 phi + 72 phi^2) + 9 sigma^2 m2, DN^2, at the reference exposure."""
        mu, delta, phi, sigma = (self.value(n, point) for n in ("mu", "delta", "phi", "sigma"))
        q = math.exp(delta**2)
        square = math.exp(2 * mu + delta**2)  # m1^2
        return square * ((q - 1) * (1 - 16 * phi + 72 * phi**2) + 9 * sigma**2 * q)
