"""Hot pixels that are all about equally hot: one narrow peak far above the core."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.guesses.evidence import curve, shows

FAR = 5.0  # robust standard deviations of the pattern from which a pixel counts as hot
FEWEST = 20  # hot pixels that show how they are spread
NARROW = 0.4  # quartile distance over median; 1.6 where amplitudes are exponential
_QUARTILES = 1.349  # between the quartiles of a normal distribution, standard deviations
_VALLEY = 3.0  # standard deviations of the counts by which a second peak is above the valley


@dataclass(frozen=True)
class Peak:
    """A narrow peak of hot pixels.

    Parameters
    ----------
    amplitude : ndarray
        Median signal, DN, one a setting; NaN where it is not seen.
    share : float
        Of all pixels.
    width : float
        Standard deviation over the median, without that of the core.
    second : bool
        Whether a second peak is seen at twice the signal.
    """

    amplitude: np.ndarray
    share: float
    width: float
    second: bool


def single_peak(clues: Clues) -> Peak | None:
    """The peak of hot pixels that are nearly alike; None where they are not.

    Hot pixels of other origin spread over a decade. Where each comes of one rare atom of many, nu
    in a pixel by Poisson's law, a share nu / 2 of them has two and makes a peak at twice the
    signal.
    """
    if not shows(clues, [f"hot_count_{k}" for k in (5, 8, 16)]):
        return None
    sigma = np.asarray(clues.measured("pattern_noise_core"), float)
    amplitude = np.full(sigma.size, np.nan)
    shares, widths, second = [], [], False
    for setting in range(sigma.size):
        x, n = (curve(clues, f"pattern_hist_{axis}", setting) for axis in "xn")
        if x is None or n is None or not np.isfinite(sigma[setting]):
            continue
        summed = np.cumsum(n)
        x = x - np.interp(0.5 * summed[-1], summed, x)
        hot = x > FAR * sigma[setting]
        count = np.cumsum(n[hot])
        if not hot.any() or count[-1] < FEWEST:
            continue
        low, middle, high = np.interp(np.array([0.25, 0.5, 0.75]) * count[-1], count, x[hot])
        if high - low < NARROW * middle:
            amplitude[setting] = middle
            shares.append(float(count[-1] / summed[-1]))
            spread = ((high - low) / _QUARTILES) ** 2 - sigma[setting] ** 2
            widths.append(float(np.sqrt(max(spread, 0.0)) / middle))
            second |= _second(x, n, float(middle))
    if not shares:
        return None
    return Peak(amplitude, max(shares), float(np.median(widths)), second)


def _second(x: np.ndarray, n: np.ndarray, middle: float) -> bool:
    """Whether more pixels have about twice the signal than about one and a half of it."""
    valley, peak = (float(n[np.abs(x - k * middle) < 0.25 * middle].sum()) for k in (1.5, 2.0))
    return peak - valley > _VALLEY * np.sqrt(max(peak + valley, 1.0))
