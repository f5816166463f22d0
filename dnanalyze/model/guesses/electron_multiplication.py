"""First guesses of electron_multiplication: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.electron_multiplication import ElectronMultiplication
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import shows

# Third cumulant over that of counting noise from which a register is worth a trial. Below its
# inverse it is that of no counted charge.
CUMULANT_RATIO = 1.15
HIGH_GAIN, MUCH = 2.0, 0.1  # excess noise factor; clock-induced charge that makes a kind, e-


def guess(effect: type[ElectronMultiplication], clues: Clues) -> list[Effect]:
    """The excess noise factor from the skewness of the temporal noise, and that of high gain.

    Where pixels hold an electron or none, hot pixels and the long tail of the register are not told
    apart, and the skewness tells no factor: that of high gain is then the only one. Slopes of
    variance and third cumulant over the mean are F2 K and F2 (2 F2 - 1) K^2. Where the third
    cumulant is 0 there is no charge: what the coldest setting has above that level bounds the
    clock-induced charge.
    """
    if not shows(clues, effect.fingerprint, 0):
        return []
    mean, variance = hints.photon_transfer(clues)
    third = clues.measured("temporal_third_cumulant") / hints.gains(clues) ** 3
    good = np.isfinite(mean) & np.isfinite(third) & (variance > 0)
    if good.sum() < 2 or np.ptp(mean[good]) <= 0:
        return []
    slope, _ = np.polyfit(mean[good], variance[good], 1, w=1.0 / variance[good])
    skewed, zero = np.polyfit(mean[good], third[good], 1, w=variance[good] ** -1.5)
    if slope <= 0:
        return []
    ratio = float(min(skewed / slope**2, 1.9))
    if 1.0 / CUMULANT_RATIO < ratio < CUMULANT_RATIO:
        return []
    guesses: list[Effect] = [effect.within(excess=HIGH_GAIN)]
    if ratio < CUMULANT_RATIO:
        return guesses
    factor = round(1.0 / (2.0 - ratio), 3)
    if factor != HIGH_GAIN:
        guesses.append(effect.within(excess=factor))
    induced = HIGH_GAIN * float(mean[good].min() + zero / skewed) / slope
    if induced > MUCH:
        guesses.append(effect.within(excess=HIGH_GAIN, induced=induced))
    return guesses
