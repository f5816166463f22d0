"""Equally spaced peaks in the distribution of the DSNU: dark current in steps."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from dnanalyze.analyzers.estimators.quantiles import Ordered
from dnanalyze.analyzers.statistics import Value

BINS = 2048
FOUND = 12.0  # ratio from which a peak is no chance
TRIM = 0.0005  # share left out on either side


def pattern_steps(ordered: Ordered, residue: float) -> tuple[Value, Value] | None:
    """Strength and spacing of equally spaced peaks.

    The power of the empirical characteristic function at frequency 1/q, over the higher of its
    means just below and just above that frequency: a smooth law's power falls, so that its ratio
    is below 1, and where none is left, n |mean exp(2 pi i x/q)|^2 is an exponential deviate.

    Parameters
    ----------
    ordered : Ordered
        Pixels of the DSNU, DN.
    residue : float
        Standard deviation of the temporal noise that is left in it, DN; spacings start at 3 of it.

    Returns
    -------
    strength, spacing : Value
        Largest ratio, 1 at least, its relative error; the spacing q, DN. None where no
        spacing is possible.
    """
    low, high = ordered.quantile(np.array([TRIM, 1 - TRIM]))
    least = max(3 * residue, 2.5 * ordered.step)
    if least <= 0 or not high - low > 4 * least:
        return None
    width = min((high - low) / 256, least / 4)
    if ordered.step:
        width = ordered.step * max(1, round(width / ordered.step))
    bins = min(int((high - low) / width) + 1, 1 << 16)
    edges = low + width * np.arange(bins + 1)
    counts = np.diff(np.searchsorted(ordered.sorted, edges)).astype(float)
    size = 1 << (2 * bins - 1).bit_length()
    power = np.abs(np.fft.rfft(counts - counts.mean(), size)) ** 2 / max(counts.sum(), 1.0)
    frequency = np.arange(power.size) / (size * width)
    spread = ordered.robust_sigma()
    first = int(np.searchsorted(frequency, max(2.0 / (high - low), 0.5 / spread)))
    last = int(np.searchsorted(frequency, 1.0 / least))
    if last - first < 8:
        return None
    k = _tried(first, last)
    ratio = power[k] / np.maximum(_floor(power, k), 0.5)
    best = int(np.argmax(ratio))
    trials = max((frequency[last] - frequency[first]) * 4 * spread, 2.0)
    extreme = 1.28 / (math.log(trials) + 0.577)  # Gumbel's law
    error = math.hypot(0.2, 2 / math.sqrt(max(power[k[best]], 1.0)))  # 0.2: that of the floor
    se = error if ratio[best] > FOUND else max(extreme, 0.4)
    strength = Value(float(max(ratio[best], 1.0)), se)
    first_peak = int(np.argmax(ratio >= min(ratio[best], max(FOUND, math.sqrt(ratio[best])))))
    near = (k >= k[first_peak]) & (k < 1.3 * k[first_peak])  # the lowest harmonic that stands out
    spacing = float(1 / frequency[_crest(power, k[near][np.argmax(ratio[near])])])
    return strength, Value(spacing, spacing**2 / (high - low) / math.sqrt(max(ratio[best], 1.0)))


@lru_cache(maxsize=64)
def _tried(first: int, last: int) -> np.ndarray:
    """Frequencies at which a peak is looked for."""
    return np.unique(np.geomspace(first, last, 256).astype(int))


def _crest(power: np.ndarray, i: int) -> int:
    """The local maximum of the power uphill from ``i``."""
    while 0 < i < power.size - 1 and max(power[i - 1], power[i + 1]) > power[i]:
        i += 1 if power[i + 1] > power[i - 1] else -1
    return i


def _floor(power: np.ndarray, k: np.ndarray) -> np.ndarray:
    """The higher of the means on either side: above what a falling spectrum has at ``k``."""
    near, far = 1.2, 1.7
    summed = np.concatenate(([0.0], np.cumsum(power)))

    def mean(low: np.ndarray, high: np.ndarray) -> np.ndarray:
        low, high = np.maximum(low.astype(int), 1), np.minimum(high.astype(int), power.size)
        high = np.maximum(high, low + 1)
        return np.asarray((summed[high] - summed[low]) / (high - low))

    below = mean(k / far, k / near)
    above = mean(np.ceil(k * near), np.ceil(k * far) + 1)
    return np.maximum(below, above)
