"""Counting noise of the dark charge: Poisson in electrons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model import draws, hints
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter
from dnanalyze.model.evidence import shows


@dataclass(frozen=True)
class DarkShotNoise(Effect):
    """y = K Pois(max(h, 0)/K) + min(h, 0): the charge arrives in whole electrons."""

    name: ClassVar[str] = "dark_shot_noise"
    stage: ClassVar[Stage] = Stage.ARRIVAL
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = (
        "counting noise of the dark charge; variance proportional to the dark signal"
    )
    physics: ClassVar[str] = (
        "Dark electrons are generated one by one and independently, so their number in an "
        "exposure is Poisson: its variance equals its mean. In DN the temporal variance is K "
        "times the dark signal above the black level, with K the conversion gain (DN per "
        "electron, proportional to the analogue gain). It grows with temperature and exposure "
        "exactly as the dark signal does, pixel by pixel, so hot pixels are noisier. It is "
        "white. Only less dark charge (cooling, shorter exposure) or averaging reduces it. The "
        "slope of temporal variance over mean (the photon-transfer method) measures K."
    )
    formula: ClassVar[str] = (
        "y = K Pois(max(h,0)/K) + min(h,0); mean h, variance K h, third cumulant K^2 h"
    )
    references: ClassVar[tuple[str, ...]] = (
        "EMVA Standard 1288, release 4.0",
        "Mullikin et al., SPIE 2173 (1994)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_noise",
        "noise_at_999",
        "noise_at_99",
        "noise_at_90",
        "temporal_noise_core",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "read_noise": "read noise does not grow with the dark signal",
        "convolved_lognormal": (
            "the kernel's random taps give a variance that grows with the signal squared"
        ),
        "rts": "RTS noise sits in few pixels, shot noise in all",
    }

    dn_per_e: float = parameter(0.5, "DN/e-", 1e-4, 1e3, "conversion gain K at the reference gain")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Replace the mean charge by a count."""
        k = self.value("dn_per_e", site.point) * site.gain_ratio
        return draws.counts(signal, k, site.moment.child("").key, site.window, site.shape[1])

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """Slope of temporal variance over mean, between settings and between pixels of a frame."""
        if not (shows(clues, cls.fingerprint) or shows(clues, cls.fingerprint, -1)):
            return []
        slopes = [s for s in (_slope_of_settings(clues), _slope_of_pixels(clues)) if s and s > 0]
        if len(slopes) == 2 and 0.5 < slopes[0] / slopes[1] < 2:
            slopes = slopes[:1]
        return [cls(**hints.clip(cls, dn_per_e=s)) for s in slopes]


def _slope_of_settings(clues: Clues) -> float | None:
    gain = hints.gains(clues)
    mean = np.asarray(clues.measured("mean"), float) / gain
    variance = (np.asarray(clues.measured("temporal_noise"), float) / gain) ** 2
    good = np.isfinite(mean) & np.isfinite(variance)
    if good.sum() < 2 or np.ptp(mean[good]) <= 0:
        return None
    weight = 1.0 / np.maximum(variance[good], 1e-12)  # relative errors are alike
    return float(np.polyfit(mean[good], variance[good], 1, w=weight)[0])


def _slope_of_pixels(clues: Clues) -> float | None:
    """Variance of the upper percent over that of the lower half, over their distance in level."""
    rise = np.asarray(clues.measured("noise_at_99"), float) - clues.measured("noise_at_50")
    level = np.asarray(clues.measured("pattern_q0.99"), float)  # above the median
    slope = rise / np.where(level > 0, level, np.nan) / hints.gains(clues)
    return float(np.nanmedian(slope)) if np.isfinite(slope).any() else None
