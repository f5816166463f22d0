"""Recursive averaging over frames."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter

TRACE = 0.02  # of a frame that is far back


@dataclass(frozen=True)
class TemporalDenoise(Effect):
    """y'_n = (1 - a) y_n + a y'_(n-1), begun before the first frame or with it."""

    name: ClassVar[str] = "temporal_denoise"
    stage: ClassVar[Stage] = Stage.TEMPORAL_FILTER
    varies: ClassVar[str] = "digital"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "Temporal denoise: each frame is mixed with those before it."
    physics: ClassVar[str] = (
        "Video pipelines mix every frame with a running average of those before. A weight a "
        "of the previous output lowers the temporal variance to (1-a)/(1+a) and correlates "
        "successive frames, with a correlation of a to the power of their distance; the fixed "
        "pattern, the spectrum within a frame and the hot pixels are unchanged. Filters for "
        "moving scenes skip pixels that change by more than a threshold, so only small noise "
        "is averaged. Read noise and other temporal statistics are underestimated. It acts at "
        "every temperature. Remedy: switch it off, or take frames far apart."
    )
    formula: ClassVar[str] = (
        "y'_n = (1-a) y_n + a y'_(n-1);  variance (1-a)/(1+a), correlation a^lag"
    )
    references: ClassVar[tuple[str, ...]] = ()
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_r1", "temporal_noise", "pattern_correlation",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "rts": "a few pixels are correlated in time; the median pixel is not",
        "persistence": "bright pixels only, and the mean falls after a bright frame",
        "offset_drift": "whole frames move together; less their means they are independent",
        "denoise": "correlates neighbours, not frames",
    }
    memory: ClassVar[int] = 8

    share: float = parameter(0.2, "1", 0.0, 0.7, "weight a of the previous output", "linear")
    threshold: float = parameter(
        20.0, "DN", 0.01, 1e5, ("change at which the average of a pixel restarts (motion)")
    )
    motion: str = choice("off", "whether a threshold is applied", "off", "on")
    before: str = choice(
        "running",
        ("frames before the first: frames like it (running), or none (empty)"),
        "running",
        "empty",
    )

    def warm_up(self, point: OperatingPoint) -> int:
        """As many frames as leave a trace of a fiftieth, where the camera was running."""
        share = self.value("share", point)
        if self.before == "empty" or share <= 0:
            return 0
        return min(self.memory, math.ceil(math.log(TRACE) / math.log(share)))

    def inactive_parameters(self) -> tuple[str, ...]:
        """The threshold where there is none."""
        return ("threshold",) if self.motion == "off" else ()

    def nuisance_bias(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """The recursion leaves (1 - a)/(1 + a) of the variance between frames."""
        if not isinstance(self.share, (int, float)):
            return 1.0, 0.0
        variance = (1.0 + self.share) / (1.0 - self.share)
        factors = {"read_noise.sigma": variance**0.5, "dark_shot_noise.dn_per_e": variance}
        return factors.get(name, 1.0), 0.0

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Run the recursion over the frames at hand; codes stay codes."""
        from dnanalyze.model import filters

        share = np.float32(self.value("share", site.point))
        threshold = np.float32(self.value("threshold", site.point))
        state = signal[0]
        for present in signal[1:]:
            step = state - present
            mixed = present + share * step
            if self.motion == "on":
                mixed = np.where(np.abs(step) > threshold, present, mixed)
            state = mixed
        return filters.rounded_like(signal[-1], state)
