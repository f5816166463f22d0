"""Charge of earlier frames that comes out late."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter


@dataclass(frozen=True)
class Persistence(Effect):
    """y_n += a sum over k of e^(-k dt/tau) y_(n-k), k = 1 to 4."""

    name: ClassVar[str] = "persistence"
    stage: ClassVar[Stage] = Stage.COUPLING
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "part of each frame's charge returns in the frames after it (lag)"
    physics: ClassVar[str] = (
        "Traps, or an incomplete transfer of charge, hold back a part of a pixel's charge and "
        "release it over the following frames: lag within a frame or two, persistence over "
        "seconds to hours. In a series of darks the level rises over the first frames until "
        "release balances capture, and neighbouring frames share not only the pattern but a part "
        "of their noise. Traps empty faster when warm. Remedies: reset or flush frames before "
        "the first one, discard the first frames, no bright scenes before darks."
    )
    formula: ClassVar[str] = (
        "y_n = h_n + a sum_{k=1..min(n,4)} e^(-k dt/tau) h_(n-k), dt = the exposure (1 if "
        "unknown); nothing before frame 0; lag-1 autocorrelation of the noise about a "
        "e^(-dt/tau)"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Janesick, Scientific Charge-Coupled Devices, SPIE Press (2001)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = ("temporal_r1", "drift", "temporal_noise")
    confused_with: ClassVar[dict[str, str]] = {
        "offset_drift": "a drifting offset moves all pixels equally, independent of their signal",
        "temporal_denoise": "a temporal filter correlates the read noise too and lowers the noise",
        "rts": "RTS correlates the frames of a few pixels only",
    }
    memory: ClassVar[int] = 4

    amplitude: float = parameter(1e-3, "1", 1e-6, 0.5, "share a of an earlier frame's charge")
    tau_s: float = parameter(
        1.0, "s", 1e-4, 1e5, "time constant of the release; in frames if the exposure is unknown"
    )
    before: str = choice(
        "empty",
        ("frames before the first: none (empty), or frames like it (running)"),
        "empty",
        "running",
    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add what the last frames left."""
        weights = self.weights(site)
        past = signal[-2::-1]
        last = site.frame if self.before == "empty" else self.memory
        left = np.zeros_like(signal[-1])
        for weight, frame in zip(weights[:last], past[:last], strict=True):
            left += weight * frame  # in this order, whatever library of linear algebra there is
        return signal[-1] + left

    def weights(self, site: Site) -> np.ndarray:
        """Share of the charge of the 1, 2, 3 and 4 frames earlier."""
        step = 1.0 if site.point.exposure_s is None else site.point.exposure_s
        k = np.arange(1, self.memory + 1)
        decay = np.exp(-k * step / self.value("tau_s", site.point))
        return (self.value("amplitude", site.point) * decay).astype(np.float32)
