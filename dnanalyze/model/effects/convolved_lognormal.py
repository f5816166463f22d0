"""The paper's model: a log-normal seed under a 3x3 kernel that is random at every pixel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Site, Stage, choice, parameter


@dataclass(frozen=True)
class ConvolvedLognormal(Effect):
    """f ~ N(mu, delta^2), L = exp f; h = sum (K + eps) L, eps ~ N(0, sigma^2) for every pixel and tap.

    Given L, the random part is exactly sigma sqrt(sum L^2) N(0,1): one normal a pixel, not nine.
    """

    name: ClassVar[str] = "convolved_lognormal"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "both"
    reach: ClassVar[int] = 1

    mu: float = parameter(0.0, "ln DN", -20.0, 12.0, "mean of the log of the seed", "linear")
    delta: float = parameter(0.5, "ln DN", 1e-4, 4.0, "spread of the log of the seed")
    phi: float = parameter(
        1e-3, "1", 0.0, 0.125, "kernel weight of each of the 8 neighbours", "linear"
    )
    sigma: float = parameter(0.01, "1", 1e-6, 1e6, "spread of each random kernel tap")
    seed: str = choice("fixed", "seed in the silicon, or redrawn each frame", "fixed", "redrawn")
    exposure: str = choice("proportional", "signal over exposure", "proportional", "none")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the convolved seed to the signal."""
        if self.seed == "fixed":
            mean, norm = site.keep("seed", lambda: self._seed(site, site.fixed_normal("seed")))
        else:
            mean, norm = self._seed(site, site.normal("seed"))
        sigma = np.float32(self.value("sigma", site.point))
        return signal + mean + sigma * norm * site.normal("kernel")

    def _seed(self, site: Site, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        mu, delta, phi = (np.float32(self.value(n, site.point)) for n in ("mu", "delta", "phi"))
        light = np.exp(mu + delta * z)
        if self.exposure == "proportional":
            light *= np.float32(site.exposure_ratio)
        mean = phi * _box(light) + (1 - 9 * phi) * light
        return mean, np.sqrt(_box(light * light))


def _box(a: np.ndarray) -> np.ndarray:
    """Sum over the 3x3 window; the edge is repeated."""
    p = np.pad(a, 1, mode="edge")
    r = p[:-2] + p[1:-1] + p[2:]
    return r[:, :-2] + r[:, 1:-1] + r[:, 2:]
