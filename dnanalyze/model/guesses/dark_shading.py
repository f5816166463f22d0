"""First guesses of dark_shading: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.bounds import clip
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.dark_shading import DarkShading
from dnanalyze.model.fingerprints import BANDS, centre, named
from dnanalyze.model.guesses.evidence import band_excess, curve, power_law, shows
from dnanalyze.model.guesses.surfaces import shading

GROWING = 0.5  # share of the blocks' variance at the highest level that the slope must explain


def guess(effect: type[DarkShading], clues: Clues) -> list[Effect]:
    """Slope of the block means' standard deviation over the level; exponent from the masked power.

    None where the blocks vary as much at the lowest level: that is shading of the offset.
    """
    if shading(clues) is None and not shows(
        clues, ("shading_mid", *named("pattern_psd", BANDS[:3]))
    ):
        return []
    level = np.asarray(clues.measured("mean"), float)
    spread = np.full(level.size, np.nan)
    for j in range(level.size):
        blocks = curve(clues, "block_means", j)
        if blocks is not None and min(blocks.shape) >= 3:
            spread[j] = float(np.var(blocks))
    good = np.isfinite(level) & np.isfinite(spread)
    if good.sum() < 2 or np.ptp(level[good]) <= 0:
        return []
    square = (level[good] - level[good].min()) ** 2
    away = square - square.mean()
    slope = float(away @ spread[good] / (away @ away))
    if slope * square.max() < GROWING * spread[good].max():
        return []
    power = band_excess(clues, "pattern_psd", BANDS)[:, good] @ square
    seen = np.array([shows(clues, [name], 1, 1.5) for name in named("pattern_psd", BANDS)], float)
    frequency = np.array([centre(band) for band in BANDS])
    alpha = power_law(frequency, power, seen)[1] or 3.0
    return [effect(**clip(effect, rms=math.sqrt(slope), alpha=alpha))]
