"""First guesses of convolved_lognormal: its parameters as the statistics suggest them."""

from __future__ import annotations

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal


def guess(effect: type[ConvolvedLognormal], clues: Clues) -> list[Effect]:
    """None: every model begins with this effect, started from moments by the fit."""
    return []
