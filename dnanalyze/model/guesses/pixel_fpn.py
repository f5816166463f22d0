"""First guesses of pixel_fpn: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import shows


def guess(effect: type[PixelFpn], clues: Clues) -> list[Effect]:
    """From the unexplained pattern variance of the settings with the least pattern."""
    low = ("pattern_q0.01", "pattern_q0.1")
    high = tuple(n for n in effect.fingerprint if n not in low)
    if not (shows(clues, high) or shows(clues, low, -1)):
        return []
    name = "pattern_noise_core"
    if not np.isfinite(clues.measured(name)).any():
        name = "frame_noise_core"
    sigma = hints.unexplained_sigma(clues, name)
    return [] if sigma is None else [effect.within(sigma=sigma)]
