"""First guesses of hot_clusters: its parameters as the statistics suggest them."""

from __future__ import annotations

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.hot_clusters import HotClusters
from dnanalyze.model.guesses.evidence import shows
from dnanalyze.model.guesses.hot_counts import hot_signals


def guess(effect: type[HotClusters], clues: Clues) -> list[Effect]:
    """The tail of the unexplained hot pixels, split into small and large clusters."""
    if not shows(clues, ("hot_pairs", "hot_halo_2")):
        return []
    return [e for hot in hot_signals(clues) for e in effect.of_hot_signal(hot)]
