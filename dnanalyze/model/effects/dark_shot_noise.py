"""Counting noise of the dark charge: Poisson in electrons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model import draws
from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter


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
        "electron, proportional to the analog gain). It grows with temperature and exposure "
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
        "electron_multiplication": "a register multiplies the third cumulant of the noise more "
        "than its variance: 1.5 times that of counting noise of the same photon transfer",
        "rts": "RTS noise occurs in few pixels, shot noise in all",
    }

    dn_per_e: float = parameter(0.5, "DN/e-", 1e-4, 1e3, "conversion gain K at the reference gain")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Replace the mean charge by a count."""
        k = self.value("dn_per_e", site.point) * site.gain_ratio
        return draws.counts(signal, k, site.frame_stream.child("").key, site.window, site.shape[1])
