"""Names of the statistics over bands of frequencies, as fingerprints list them."""

from __future__ import annotations

import math
from collections.abc import Iterable

BANDS = ("0_0.01", "0.01_0.02", "0.02_0.04", "0.04_0.08", "0.08_0.16", "0.16_0.25", "0.25_0.35",
         "0.35_0.5", "0.5_0.71")  # fmt: skip
"""Radial frequencies, cycles/pixel."""

LINE_BANDS = ("0_0.02", "0.02_0.1", "0.1_0.3", "0.3_0.5")
"""Frequencies along an axis, cycles/pixel."""


def edges(band: str) -> tuple[float, float]:
    """Ends of a band in cycles/pixel, from its name."""
    low, high = band.split("_")
    return float(low), float(high)


def centre(band: str) -> float:
    """Geometric mean frequency of a band; a band from zero counts from a fifth of its end."""
    low, high = edges(band)
    return math.sqrt(max(low, high / 5) * high)


def named(prefix: str, bands: Iterable[str]) -> tuple[str, ...]:
    """Names of the statistics of a set of bands."""
    return tuple(f"{prefix}_{band}" for band in bands)
