"""First guesses of dark_shading: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.dark_shading import DarkShading
from dnanalyze.model.fingerprints import BANDS, centre, named
from dnanalyze.model.guesses.evidence import band_excess, curve, over_signal, power_law, shows
from dnanalyze.model.guesses.surfaces import shading


def guess(effect: type[DarkShading], clues: Clues) -> list[Effect]:
    """Slope of the block means' standard deviation over the level; exponent from the masked power.

    None where the blocks vary as much at the lowest level: that is shading of the offset.
    """
    if shading(clues) is None and not shows(
        clues, ("shading_mid", *named("pattern_psd", BANDS[:3]))
    ):
        return []
    spread = np.full(len(clues.points), np.nan)
    for j in range(spread.size):
        blocks = curve(clues, "block_means", j)
        if blocks is not None and min(blocks.shape) >= 3:
            spread[j] = float(np.var(blocks))
    both = over_signal(clues, spread)
    if both is None:
        return []
    square = both[0] ** 2
    away = square - square.mean()
    slope = float(away @ both[1] / (away @ away))
    if slope * square.max() < 0.5 * both[1].max():  # half of what the blocks vary by
        return []
    known = np.isfinite(spread) & np.isfinite(clues.measured("mean"))
    power = band_excess(clues, "pattern_psd", BANDS)[:, known] @ square
    seen = np.array([shows(clues, [name], 1, 1.5) for name in named("pattern_psd", BANDS)], float)
    frequency = np.array([centre(band) for band in BANDS])
    alpha = power_law(frequency, power, seen)[1] or 3.0
    return [effect.within(rms=math.sqrt(slope), alpha=alpha)]
