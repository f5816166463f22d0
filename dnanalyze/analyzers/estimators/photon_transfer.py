"""Temporal variance over level within one operating point: the points of a photon transfer curve.

Hot pixels of a dark frame hold more charge than the others, and so more shot noise (Janesick,
Photon Transfer, SPIE 2007). Telegraph noise and particle hits are in some of the pixels of a level:
a midmean of their variances leaves these out. What moves whole frames is no noise of the pixels:
with it the variances follow a noncentral chi-square law.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.stats import ncx2

LEAST_PIXELS = 30  # of a level: its variance is then good to 35 % with two frames, 17 % with four
FIRST, RATIO = 4.0, math.sqrt(2.0)  # first limit above the median, robust sigmas; next ones
UNLIKE = 0.01  # least relative error: variances within a level differ (tests: bias within 3 %)
# Share of the variance of the moves by which that of a level may differ: of log-normal charge whose
# spread over the pixels is 0.3, the median pixel has exp(-0.09) of the mean square.
MOVES_UNLIKE = 0.1
QUARTILES = np.array([0.25, 0.75])


def transfer_points(
    level: np.ndarray,
    variance: np.ndarray,
    centre: float,
    sigma: float,
    frames: int,
    moved: float = 0.0,
) -> np.ndarray:
    """Level and temporal variance of the pixels of like level.

    Parameters
    ----------
    level, variance : ndarray
        Mean over the frames, DN, and unbiased variance over them, DN^2, of each pixel.
    centre, sigma : float
        Median and robust sigma of ``level``, DN.
    frames : int
        At least 2.
    moved : float
        Variance of the levels of the frames, DN^2, which is in that of every pixel.

    Returns
    -------
    ndarray
        (levels, 4): mean level, DN; temporal variance and its standard error, DN^2; pixels. The
        first is that of the middle half of the pixels. None where frames move by more than the
        noise: moves of the charge differ from pixel to pixel.
    """
    if moved > float(variance.mean(dtype=np.float64)) - moved:
        return np.empty((0, 4))
    above = level.ravel() - np.float32(centre)
    flat = variance.ravel()
    rows = [_row(above, flat, np.abs(above) <= 0.6745 * sigma, frames, moved)]
    bright = np.flatnonzero(above > FIRST * sigma)
    high, noise = above[bright], flat[bright]
    which = np.floor(np.log(high / (FIRST * sigma)) / math.log(RATIO)).astype(int)
    for k in np.unique(which):
        here = which == k
        if np.count_nonzero(here) >= LEAST_PIXELS:
            rows.append(_row(high, noise, here, frames, moved))
    found = np.array(rows)
    found[:, 0] += centre
    return found


def _row(
    level: np.ndarray, variance: np.ndarray, here: np.ndarray, frames: int, moved: float
) -> list[float]:
    """Mean level; variance by the midmean of the pixels' variances, its error; pixels."""
    own = variance[here].astype(float)
    low, high = np.quantile(own, QUARTILES)
    cut = np.clip(own, low, high)
    # mean between the quartiles: ends in proportion, for variances of codes are tied
    middle = 2.0 * float(cut.mean()) - 0.5 * float(low + high)
    still = float(own.mean()) - moved
    usual = _usual(frames - 1, (frames - 1) * moved / still if still > 0 else 0.0)
    error = 2.0 * float(cut.std()) / math.sqrt(own.size)
    error = max(error, UNLIKE * middle, 1e-9) / usual
    error = math.hypot(error, MOVES_UNLIKE * moved)
    return [float(level[here].mean()), max(middle / usual - moved, 0.0), error, float(own.size)]


def _usual(freedom: int, away: float) -> float:
    """Midmean over mean of a noncentral chi-square deviate; ``away``: its noncentrality."""
    q = ncx2.ppf(QUARTILES, freedom, away)
    within = [float(np.diff(ncx2.cdf(q, freedom + k, away))[0]) for k in (2, 4)]
    return (freedom * within[0] + away * within[1]) / 0.5 / (freedom + away)
