"""First guesses of scaled_lines: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.analyzers.estimators.line_defects import against_neighbours, standing_out
from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.scaled_lines import ScaledLines
from dnanalyze.model.guesses import hints


def guess(effect: type[ScaledLines], clues: Clues) -> list[Effect]:
    """The lines whose offset grows with the level, and its growth over that of the level."""
    level = clues.measured("mean") / hints.gains(clues)
    if np.isfinite(level).sum() < 2:
        return []
    low, high = int(np.nanargmin(level)), int(np.nanargmax(level))
    rise = level[high] - level[low]
    if rise <= 0:
        return []
    guesses: list[Effect] = []
    for axis, across in (("columns", 1), ("rows", 0)):
        (places, cold), (_, warm) = clues.lines(axis, low), clues.lines(axis, high)
        if cold.size != warm.size or cold.size < 2:
            continue
        gains = hints.gains(clues)
        cold, warm = cold / gains[low], warm / gains[high]
        far, shares = standing_out((warm - cold) / rise)
        offsets = against_neighbours(warm)[far]
        # most of an offset at the highest level must come with the level
        grown = np.abs(shares) * rise > 0.5 * np.abs(offsets)
        far, shares = far[grown], np.maximum(shares[grown], -1.0)
        if not np.any(shares):
            continue
        rms = float(np.sqrt(np.mean(shares**2)))
        guesses.append(
            effect(
                bounded(effect, "fraction", far.size / clues.field[across]),
                bounded(effect, "sigma", rms),
                axis,
                tuple(int(p) for p in places[far]),
                tuple(round(float(s), 4) for s in shares / rms),
            )
        )
    return guesses
