"""Multiplication of codes after the converter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter

_FINE = 2048  # parts of a code within which a product is a half


@dataclass(frozen=True)
class DigitalGain(Effect):
    """y = round((y - b) s + b) on codes."""

    name: ClassVar[str] = "digital_gain"
    stage: ClassVar[Stage] = Stage.DIGITAL
    varies: ClassVar[str] = "digital"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = (
        "Codes multiplied after the converter: gaps or spikes in the histogram."
    )
    physics: ClassVar[str] = (
        "A gain applied to codes, in the sensor or in the camera, brings no information: with s > "
        "1 some codes are never reached (gaps, one in s/(s-1)), with s < 1 several codes fall "
        "together (spikes, one in s/(1-s)). Noise and dark signal both grow by s, so only the "
        "histogram shows it. It is exact, the same at every temperature, and changes with the gain "
        "setting where the camera makes up its upper gains this way. Remedy: divide by s and "
        "round; use analog gain instead."
    )
    formula: ClassVar[str] = "y = round((x - b) s + b), x and y whole numbers"
    references: ClassVar[tuple[str, ...]] = ()
    fingerprint: ClassVar[tuple[str, ...]] = ("code_comb", "unused_codes", "code_roughness")
    confused_with: ClassVar[dict[str, str]] = {
        "missing_codes": "irregular widths, or a period that is a power of two; the pattern is "
        "fixed to the codes, and widths take all values",
        "quantization": "a coarse step leaves all codes but every n-th empty: s a whole number",
    }

    gain: float = parameter(1.25, "1", 0.5, 4.0, "factor s", "held")
    offset: float = parameter(
        0.0, "DN", -1e5, 1e5, "code b that maps to itself, commonly the black level", "held"
    )

    top: float = parameter(65535.0, "DN", 0.0, 1e7, "highest code of the output", "held")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Multiply, round, and cut off at the top."""
        s, b = self.value("gain", site.point), self.value("offset", site.point)
        codes = rounded_products((signal - np.float32(b)) * np.float32(s) + np.float32(b))
        return np.minimum(codes, np.float32(self.value("top", site.point)))

    def nuisance_bias(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """Whatever comes before is that much smaller than the codes say."""
        if not (isinstance(self.gain, (int, float)) and isinstance(self.offset, (int, float))):
            return 1.0, 0.0
        if name == "pedestal":
            return 1.0 / self.gain, self.offset * (1.0 - 1.0 / self.gain)
        if name.startswith("convolved_lognormal.mu"):
            return 1.0, -math.log(self.gain)
        return (1.0 / self.gain if unit in ("DN", "DN/e-") else 1.0), 0.0


def rounded_products(codes: np.ndarray) -> np.ndarray:
    """Whole codes, halves to even ones: also those that the product misses by its rounding.

    1.3 times 15 is a half, and not so in float32; which code stays empty hangs on it.
    """
    fine = np.float32(_FINE)
    return np.rint(np.rint(codes * fine) / fine)
