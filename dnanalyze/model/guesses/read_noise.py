"""First guesses of read_noise: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.bounds import clip
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import shows


def guess(effect: type[ReadNoise], clues: Clues) -> list[Effect]:
    """From the unexplained temporal variance of the least noisy settings."""
    if not shows(clues, effect.fingerprint):
        return []
    gain = hints.gains(clues)
    lost = hints.unexplained_variance(clues, "temporal_noise_core") / gain**2
    total = np.asarray(clues.measured("temporal_noise_core"), float) / gain
    good = lost[np.isfinite(lost) & (lost > 0)]
    if good.size:
        sigma = float(np.sqrt(np.median(good)))
    elif np.isfinite(total).any():
        sigma = 0.7 * float(np.nanmin(total))
    else:
        return []
    return [effect(**clip(effect, sigma=sigma))]
