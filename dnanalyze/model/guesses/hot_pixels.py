"""First guesses of hot_pixels: its parameters as the statistics suggest them."""

from __future__ import annotations

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.guesses.evidence import shows
from dnanalyze.model.guesses.hot_counts import hot_signals


def guess(effect: type[HotPixels], clues: Clues) -> list[Effect]:
    """What the counts over thresholds tell, of all settings together and of each."""
    if not shows(clues, [n for n in effect.fingerprint if n != "hot_repeat"]):
        return []
    return [e for hot in hot_signals(clues) for e in effect.of_hot_signal(hot)]
