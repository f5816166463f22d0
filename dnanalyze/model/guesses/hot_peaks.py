"""Hot pixels that are nearly alike: narrow peaks of the histogram, beside a tail or alone."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import label

from dnanalyze.model.clues import Clues
from dnanalyze.model.guesses.evidence import histogram, shows
from dnanalyze.model.guesses.hot_counts import UNLIKE
from dnanalyze.significance import CLEAR

FEWEST = 20.0  # hot pixels that show how they are spread
BIN = 0.1  # of ln DN: the bins of the measured histogram beyond 12 standard deviations
REACH = 6  # bins to either side that tell the tail: a factor of 1.8, in which few tails bend
APART = 2  # bins to either side that belong to a peak
# Statistics of which one must show hot pixels
SIGNS = *(f"hot_count_{k}" for k in (5, 8, 16)), "pattern_q0.99", "pattern_q0.999"


@dataclass(frozen=True)
class Peak:
    """A narrow peak of hot pixels."""

    amplitude: float  # mean signal above the median pixel, DN
    share: float  # of all pixels
    width: float  # standard deviation over the mean, without that of the core


def hot_peaks(clues: Clues) -> list[list[Peak]]:
    """The peaks of each setting, those of most pixels first; none without a sign of hot pixels."""
    sigma = clues.measured("pattern_noise_core")
    if not shows(clues, SIGNS, 0):
        return [[] for _ in sigma]
    found = []
    for setting, deviation in enumerate(sigma):
        seen = histogram(clues, "pattern_hist", setting)
        found.append(peaks(*seen, float(deviation)) if seen and deviation > 0.0 else [])
    return found


def peaks(centres: np.ndarray, counts: np.ndarray, sigma: float) -> list[Peak]:
    """Peaks of a histogram: above what is farther in, in pixels a DN, and above the tail.

    The tail is the running median of bins of equal ratio.

    ``centres``: DN; ``counts``: pixels; ``sigma``: robust standard deviation of the core, DN. That
    of most pixels comes first.
    """
    summed = np.cumsum(counts)
    x = centres - np.interp(0.5 * summed[-1], summed, centres)
    hot = x > CLEAR * sigma
    if counts[hot].sum() < FEWEST:
        return []
    place = np.floor(np.log(x[hot] / (CLEAR * sigma)) / BIN).astype(int)
    number = np.bincount(place, counts[hot])
    size = np.exp(BIN * np.arange(number.size))  # of the bins
    tail = np.median(np.hstack(_beside(number)), axis=1)
    # a smooth tail falls: more pixels a DN than farther in are a peak
    rest = np.maximum(tail, size * np.median(_beside(number / size)[0], axis=1))
    excess = number - tail
    beyond = number - rest > CLEAR * np.sqrt(rest + 1.0 + (UNLIKE * rest) ** 2)
    runs, count = label(beyond)
    width = np.gradient(centres)[hot]
    found = []
    for run in range(1, count + 1):
        bins = np.flatnonzero(runs == run)
        if bins[0] == 0:  # the end of the core
            continue
        own = np.isin(place, np.arange(bins[0] - 1, bins[-1] + 2))
        weight = counts[hot] * np.clip(excess / np.maximum(number, 1.0), 0.0, 1.0)[place] * own
        if weight.sum() >= FEWEST:
            found.append(_peak(x[hot], width, weight, sigma, float(summed[-1])))
    return sorted(found, key=lambda peak: -peak.share)


def _beside(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The bins below and above each that tell the tail, (bins, few) each; none beyond the last."""
    padded = np.concatenate([np.full(REACH, values[0]), values, np.zeros(REACH)])
    near = sliding_window_view(padded, 2 * REACH + 1)
    return near[:, : REACH - APART], near[:, REACH + APART + 1 :]


def _peak(
    x: np.ndarray, width: np.ndarray, weight: np.ndarray, sigma: float, pixels: float
) -> Peak:
    """The peak of weighted bins of these widths, without the spread of core and bins."""
    mean = float(np.average(x, weights=weight))
    variance = float(np.average((x - mean) ** 2 - width**2 / 12.0, weights=weight)) - sigma**2
    return Peak(mean, float(weight.sum()) / pixels, math.sqrt(max(variance, 0.0)) / mean)
