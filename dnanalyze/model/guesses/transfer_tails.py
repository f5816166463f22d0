"""First guesses of transfer_tails: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.transfer_tails import TransferTails
from dnanalyze.model.guesses.evidence import excess, shows

LENGTHS = (0.4, 1.5, 4.0)  # pixels
OPPOSITE = {"right": "left", "down": "up"}
ONE_SIDED = 2.0  # times: correlation along the tail over that across it; equal crosstalk has 1


def guess(effect: type[TransferTails], clues: Clues) -> list[Effect]:
    """Correlation of neighbours in time beyond the model's, where it is plain along one axis.

    At the noisiest setting, over the share of its variance that comes with charge. The statistics
    tell the tail's side only where the share grows along it: of either axis one is tried otherwise.
    """
    along = {"right": "temporal_corr_10", "down": "temporal_corr_01"}
    if not shows(clues, along.values()):
        return []
    noise = clues.measured("temporal_noise")
    seen = {side: excess(clues, name) for side, name in along.items()}
    if not np.isfinite(noise).any():
        return []
    loud = int(np.nanargmax(noise))
    charge = 1.0 - (np.nanmin(noise) / noise[loud]) ** 2
    rho = {side: float(found[loud]) for side, found in seen.items()}
    side = max(rho, key=lambda s: rho[s])
    across = min(rho.values())
    if charge <= 0 or not rho[side] > ONE_SIDED * max(across, 0.0):
        return []
    share = rho[side] / charge
    return [
        effect.within(loss=share / (1.0 - math.exp(-1.0 / tau)), tau=tau, towards=to, growth=growth)
        for to, growth in ((side, "none"), (side, "transfers"), (OPPOSITE[side], "transfers"))
        for tau in LENGTHS
        if share / (1.0 - math.exp(-1.0 / tau)) < 1.0
    ]
