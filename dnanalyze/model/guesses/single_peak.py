"""Hot pixels that are all about equally hot: one narrow peak far above the core."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.guesses.evidence import histogram, shows
from dnanalyze.robust import QUARTILES
from dnanalyze.significance import CLEAR

FEWEST = 20  # hot pixels that show how they are spread
NARROW = 0.4  # quartile distance over median; 1.6 where amplitudes are exponential


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
    """

    amplitude: np.ndarray
    share: float
    width: float


def single_peak(clues: Clues) -> Peak | None:
    """The peak of hot pixels that are nearly alike; None where they are not.

    Hot pixels of other origin spread over a decade.
    """
    if not shows(clues, [f"hot_count_{k}" for k in (5, 8, 16)]):
        return None
    sigma = clues.measured("pattern_noise_core")
    amplitude = np.full(sigma.size, np.nan)
    shares, widths = [], []
    for setting in range(sigma.size):
        seen = histogram(clues, "pattern_hist", setting)
        if seen is None or not np.isfinite(sigma[setting]):
            continue
        x, n = seen
        summed = np.cumsum(n)
        x = x - np.interp(0.5 * summed[-1], summed, x)
        hot = x > CLEAR * sigma[setting]
        count = np.cumsum(n[hot])
        if not hot.any() or count[-1] < FEWEST:
            continue
        low, middle, high = np.interp(np.array([0.25, 0.5, 0.75]) * count[-1], count, x[hot])
        if high - low < NARROW * middle:
            amplitude[setting] = middle
            shares.append(float(count[-1] / summed[-1]))
            spread = ((high - low) / QUARTILES) ** 2 - sigma[setting] ** 2
            widths.append(float(np.sqrt(max(spread, 0.0)) / middle))
    if not shares:
        return None
    return Peak(amplitude, max(shares), float(np.median(widths)))
