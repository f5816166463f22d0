"""First guesses of white offsets of rows or columns, fixed or new in every frame."""

from __future__ import annotations

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.guesses.evidence import shows, white_line_sigma


def guess(effect: type[Effect], clues: Clues) -> list[Effect]:
    """Sigma from the unexplained power of the axis on which these lines lie.

    Its bands are the fingerprint: of the pattern, or of differences of frames.
    """
    if not shows(clues, effect.fingerprint):
        return []
    layer, axis, *_ = effect.fingerprint[0].split("_")
    length = clues.shape[1 if axis == "rows" else 0]
    sigma = white_line_sigma(clues, f"{layer}_{axis}", length)
    return [effect.within(sigma=sigma)]
