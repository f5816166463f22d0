"""First guesses of column_gain: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.column_gain import ColumnGain
from dnanalyze.model.guesses.evidence import band_excess, mean_power, over_signal, shows


def guess(effect: type[ColumnGain], clues: Clues) -> list[Effect]:
    """Sigma from column power that grows with the mean level; needs unlike levels."""
    if not shows(clues, effect.fingerprint):
        return []
    known = over_signal(clues, mean_power(band_excess(clues, "pattern_columns")) / clues.shape[0])
    if known is None:
        return []
    signal2, variance = known[0] ** 2, known[1]
    design = np.stack([np.ones_like(signal2), signal2], axis=1)
    flat, slope = np.linalg.lstsq(design, variance, rcond=None)[0]
    if slope * signal2.max() <= max(flat, 0.0):
        return []
    return [effect.within(sigma=math.sqrt(slope))]
