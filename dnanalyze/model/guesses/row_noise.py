"""First guesses of row_noise: its parameters as the statistics suggest them."""

from __future__ import annotations

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.row_noise import RowNoise
from dnanalyze.model.guesses.evidence import shows, white_line_sigma


def guess(effect: type[RowNoise], clues: Clues) -> list[Effect]:
    """Sigma from the unexplained power of the u = 0 axis of differences of frames."""
    if not shows(clues, effect.fingerprint):
        return []
    sigma = white_line_sigma(clues, "temporal_rows", clues.shape[1])
    return [effect(bounded(effect, "sigma", sigma))]
