"""First guesses of dark_current_fpn: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.dark_current_fpn import LEFT, DarkCurrentFpn
from dnanalyze.model.guesses.evidence import shows


def guess(effect: type[DarkCurrentFpn], clues: Clues) -> list[Effect]:
    """Each law, of nearly all of the relative standard deviation of the dark signal.

    That is the growth of the pattern over that of the level, from the lowest level to the highest.
    Its offsets add to both patterns, so that it lies between the growth of the standard deviation
    and the root of that of the variance: their geometric mean.
    """
    names = [name for name in effect.fingerprint if name.startswith("pattern_q")]
    level = clues.measured("mean")
    pattern = clues.measured("pattern_noise_core")
    good = np.flatnonzero(np.isfinite(level) & np.isfinite(pattern))
    if good.size < 2 or not shows(clues, names, 0):
        return []
    low, high = good[np.argmin(level[good])], good[np.argmax(level[good])]
    grown = level[high] - level[low]
    if not (grown > 0 and pattern[high] > pattern[low]):
        return []
    straight = pattern[high] - pattern[low]
    squared = math.sqrt(pattern[high] ** 2 - pattern[low] ** 2)
    rms = math.sqrt((1.0 - LEFT**2) * straight * squared) / grown
    return [effect.within(rms=rms, law=law) for law in ("normal", "gamma", "exponential")]
