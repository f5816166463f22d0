"""First guesses of read_noise: its parameters as the statistics suggest them."""

from __future__ import annotations

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import shows


def guess(effect: type[ReadNoise], clues: Clues) -> list[Effect]:
    """From the unexplained temporal variance of the least noisy settings."""
    if not shows(clues, effect.fingerprint):
        return []
    sigma = hints.unexplained_sigma(clues, "temporal_noise_core")
    return [] if sigma is None else [effect.within(sigma=sigma)]
