"""A floor under the signal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter


@dataclass(frozen=True)
class BlackClipping(Effect):
    """y = max(y, level)."""

    name: ClassVar[str] = "black_clipping"
    stage: ClassVar[Stage] = Stage.CONVERTER
    varies: ClassVar[str] = "digital"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = (
        "The noise is cut off at the black level: everything below becomes one code."
    )
    physics: ClassVar[str] = (
        "If the black level is subtracted before the file is written, or the pedestal is too "
        "low, negative noise has no codes and is set to the lowest. The histogram then has a "
        "spike in its first bin, the mean is too high, the noise too small and skewed, above "
        "all in cold frames whose level is next to the lowest code; hot frames lie above it. "
        "Averages of many frames are biased as well. Remedy: raise the pedestal by at least "
        "five times the noise."
    )
    formula: ClassVar[str] = "y = max(y, level)"
    references: ClassVar[tuple[str, ...]] = ("Janesick, Photon Transfer, SPIE Press (2007)",)
    fingerprint: ClassVar[tuple[str, ...]] = (
        "clipped_low", "low_spike", "temporal_noise", "frame_noise_core", "temporal_noise_core",
    )  # fmt: skip
    confused_with: ClassVar[dict[str, str]] = {
        "stuck_pixels": "few, always the same pixels, even in hot frames",
        "hot_pixels": "skewed upward without a spike at the lowest code",
    }

    level: float = parameter(0.0, "DN", -1e5, 1e6, "lowest code", "held")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Cut off below the level."""
        return np.maximum(signal, np.float32(self.value("level", site.point)), out=signal)
