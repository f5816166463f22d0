"""Bands of rows: what one needs while it is drawn stays in the cache."""

from __future__ import annotations

from dnanalyze.loaders.captures import Window
from dnanalyze.model.noise_model import NoiseModel

BAND_PIXELS = 1 << 19
REACHES = 8  # a band has this many times the rows that its effects look beyond it


def bands(window: Window, rows: int) -> list[Window]:
    """The window cut into bands of at most ``rows`` rows."""
    return [
        Window(top, min(top + rows, window.bottom), window.left, window.right)
        for top in range(window.top, window.bottom, rows)
    ]


def band_rows(model: NoiseModel, columns: int) -> int:
    """Rows of a band that stays in the cache, and mostly its own where effects look around."""
    reach = sum(effect.margin() for effect in model.effects)
    return max(BAND_PIXELS // columns, REACHES * reach, 1)
