"""First guesses of crosstalk: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.bounds import clip
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.crosstalk import Crosstalk
from dnanalyze.model.guesses.evidence import excess, shows


def guess(effect: type[Crosstalk], clues: Clues) -> list[Effect]:
    """Half the unexplained correlation of neighbours in the setting where it is largest."""
    if not shows(clues, effect.fingerprint):
        return []
    shares = []
    for family in ("temporal", "pattern"):
        edge = [excess(clues, f"{family}_corr_{lag}") for lag in ("10", "01")]
        mean = np.mean(edge, axis=0)
        shares += [float(v) / 2 for v in mean[np.isfinite(mean)]]
    halo = np.asarray(excess(clues, "hot_halo"), float)
    shares += [float(v) for v in halo[np.isfinite(halo)]]
    alpha = max(shares, default=0.0)
    if alpha <= 0:
        return []
    return [effect(**clip(effect, alpha=alpha, diagonal=d)) for d in (0.25, 1.0)]
