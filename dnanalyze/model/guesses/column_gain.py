"""First guesses of column_gain: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.column_gain import ColumnGain
from dnanalyze.model.guesses.evidence import band_excess, mean_power, shows


def guess(effect: type[ColumnGain], clues: Clues) -> list[Effect]:
    """Sigma from column power that grows with the mean level; needs unlike levels."""
    if not shows(clues, effect.fingerprint):
        return []
    level = np.asarray(clues.measured("mean"), float)
    variance = mean_power(band_excess(clues, "pattern_columns")) / clues.shape[0]
    known = np.isfinite(level) & np.isfinite(variance)
    if known.sum() < 2 or np.ptp(level[known]) <= 0:
        return []
    signal2 = (level[known] - level[known].min()) ** 2
    flat, slope = np.linalg.lstsq(
        np.stack([np.ones_like(signal2), signal2], axis=1), variance[known], rcond=None
    )[0]
    if slope * signal2.max() <= max(flat, 0.0):
        return []
    return [effect(bounded(effect, "sigma", math.sqrt(slope)))]
