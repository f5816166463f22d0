"""First guesses of persistence: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.persistence import Persistence
from dnanalyze.model.guesses.evidence import excess, shows

LEAST_CHARGE = 0.05  # share of the noise's variance from which the charge's is told


def guess(effect: type[Persistence], clues: Clues) -> list[Effect]:
    """From the correlation of neighbouring frames, for a fast and for a slow release."""
    if not shows(clues, ("temporal_r1",)):
        return []
    share = _of_charge(excess(clues, "temporal_r1"), clues.measured("temporal_noise"))
    if share <= 0:
        return []
    seconds = [1.0 if p.exposure_s is None else p.exposure_s for p in clues.points]
    step = float(np.median(seconds)) or 1.0
    return [
        effect.within(amplitude=share * np.exp(1 / frames), tau_s=frames * step, before=before)
        for frames in (1.0, 8.0)
        for before in ("running", "empty")
    ]


def _of_charge(r1: np.ndarray, noise: np.ndarray) -> float:
    """Correlation of the charge of neighbouring frames, from that of all of the noise.

    What the noise has beyond the quietest setting's is the charge's; where none has, all of it.
    """
    known = np.isfinite(r1)
    if not known.any():
        return 0.0
    r1, noise = r1[known], noise[known]
    part = 1.0 - (noise.min() / noise) ** 2 if np.all(noise > 0) else np.ones_like(r1)
    part = part if part.max() > LEAST_CHARGE else np.ones_like(r1)
    return float(np.sum(part * r1) / np.sum(part**2))
