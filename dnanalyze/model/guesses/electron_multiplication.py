"""First guesses of electron_multiplication: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.electron_multiplication import ElectronMultiplication
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import histogram, shows

# Third cumulant over that of counting noise from which a register is worth a trial. Below its
# inverse it is that of no counted charge: hot pixels hide it.
CUMULANT_RATIO = 1.15
OUTLIER_DEVIATIONS = 8.0  # standard deviations beyond which pixels are hot, hit or stuck
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
    third = np.array([third_cumulant(clues, j) for j in range(mean.size)]) / hints.gains(clues) ** 3
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


def third_cumulant(clues: Clues, setting: int) -> float:
    """Of the temporal noise, DN^3, from frames and their mean; NaN where a curve is absent.

    The mean of F frames has the DSNU's, and 1/F^2 of the noise's; variances tell F.
    """
    single = _moments(histogram(clues, "histogram", setting))
    stack = _moments(histogram(clues, "pattern_hist", setting))
    noise = float(clues.measured("temporal_noise")[setting]) ** 2
    if single is None or stack is None or not noise > 0:
        return float("nan")
    part = min(max(1.0 - (single[0] - stack[0]) / noise, 0.0), 0.5)  # 1/F
    return (single[1] - stack[1]) / (1.0 - part**2)


def _moments(seen: tuple[np.ndarray, np.ndarray] | None) -> tuple[float, float] | None:
    """Variance and third central moment of a histogram, without what is far out."""
    if seen is None:
        return None
    values, counts = seen
    summed = np.cumsum(counts) / np.sum(counts)
    low, middle, high = values[np.searchsorted(summed, (0.159, 0.5, 0.841))]
    near = np.abs(values - middle) <= OUTLIER_DEVIATIONS * max(high - low, 1.0) / 2.0
    values, counts = values[near], counts[near] / np.sum(counts[near])
    away = values - counts @ values
    return float(counts @ away**2), float(counts @ away**3)
