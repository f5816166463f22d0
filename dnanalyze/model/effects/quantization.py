"""Rounding to the converter's codes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice

ROUNDING_VARIANCE = 1.0 / 12.0  # of a step's square


@dataclass(frozen=True)
class Quantization(Effect):
    """y = clip(q round(y / q), 0, 2^bits - 1)."""

    name: ClassVar[str] = "quantization"
    stage: ClassVar[Stage] = Stage.CONVERTER
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "rounding to whole codes and the converter's two ends"
    physics: ClassVar[str] = (
        "The converter gives whole codes. As long as the noise before it exceeds about 0.4 DN the "
        "rounding error is white, independent of the signal, and has variance 1/12 DN²; below "
        "that, frames repeat the same few codes, temporal noise and small offsets vanish or are "
        "exaggerated, and averaging no longer recovers them. Signals outside the range are "
        "clipped. Higher analog gain or dither restores linearity."
    )
    formula: ClassVar[str] = "y = min(max(q round(y/q), 0), 2^bits - 1); error variance q^2/12"
    references: ClassVar[tuple[str, ...]] = ("EMVA Standard 1288, release 4.0",)
    fingerprint: ClassVar[tuple[str, ...]] = ("lattice", "unused_codes", "code_roughness")
    confused_with: ClassVar[dict[str, str]] = {
        "digital_gain": (
            "a gain after the converter leaves gaps or doubled codes at a regular period"
        ),
        "missing_codes": "unequal code widths make the histogram rough, rounding alone does not",
        "read_noise": "rounding adds 1/12 DN² and no more",
    }

    bits: int = choice(16, "codes run from 0 to 2^bits - 1", *range(1, 33))
    step: int = choice(1, "distance of the codes, DN", *(2**n for n in range(17)))

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Round and clip."""
        step = np.float32(self.step)
        if step != 1:
            signal /= step
        np.rint(signal, out=signal)
        if step != 1:
            signal *= step
        return np.clip(signal, np.float32(0), np.float32(2.0**self.bits - 1), out=signal)

    def variance(self, point: OperatingPoint) -> float:
        """q^2 / 12, DN^2, where the noise before it exceeds 0.4 q."""
        return self.step**2 * ROUNDING_VARIANCE
