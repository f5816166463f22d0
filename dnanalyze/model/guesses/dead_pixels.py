"""First guess of dead_pixels: its parameter as the statistics suggest it."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.dead_pixels import DeadPixels
from dnanalyze.model.guesses.evidence import histogram, shows

LACKS = 0.8  # share of the dark signal; of a log-normal seed with delta = 0.4, 3e-5 lack as much


def guess(effect: type[DeadPixels], clues: Clues) -> list[Effect]:
    """The share of pixels that do not rise with the level from the lowest to the highest."""
    if not shows(clues, effect.fingerprint, 0):
        return []
    level = clues.measured("mean")
    good = np.flatnonzero(np.isfinite(level))
    if good.size < 2:
        return []
    high = int(good[np.argmax(level[good])])
    rise = level[high] - level[good].min()
    seen = histogram(clues, "pattern_hist", high)
    if seen is None or rise <= 0:
        return []
    x, n = seen
    summed = np.cumsum(n)
    middle = np.interp(0.5 * summed[-1], summed, x)
    share = float(np.sum(n[x < middle - LACKS * rise]) / summed[-1])
    return [effect.within(fraction=share)] if share > 0 else []
