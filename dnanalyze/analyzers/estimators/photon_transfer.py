"""Temporal variance over level within one operating point: the points of a photon transfer curve.

Hot pixels of a dark frame hold more charge than the others, and so more shot noise (Janesick,
Photon Transfer, SPIE 2007). As in EMVA 1288 the variance is a mean over pixels: of pixels whose
read noise differs it stays a line over the level, which a median or a midmean does not. Pixels that
particles hit, and those of telegraph noise many times the noise, are left out. What moves whole
frames is no noise of the pixels.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.stats import chi2

EDGE = 1.0 / 16.0  # of a level's width: its density at an end is that within so much of it
LEAST_PIXELS = 30  # of a level: its variance is then good to 35 % with two frames, 17 % with four
FIRST, RATIO = 4.0, math.sqrt(2.0)  # first limit from the median, robust sigmas; next ones
UNLIKE = 0.01  # least relative error: of what hits and telegraph noise leave (RESULTS: 2 % at most)
# A pixel is left out whose variance exceeds NOISY times what chance makes of the median one in RARE
# of the pixels. Of read noise that spreads log-normally by 0.5 that leaves out 3 % of the variance;
# of pixels that are hit in one of the frames, 9 of 10 are (RESULTS: 3 to 8 compared).
NOISY = 4.0
RARE = 1e-4
# Share of the variance of the moves by which that of a level may differ: of log-normal charge whose
# spread over the pixels is 0.3, the mean square is exp(0.09) of the squared mean.
MOVES_UNLIKE = 0.1


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
        first is that of the pixels that are not hot. None where frames move by more than the
        noise: moves of the charge differ from pixel to pixel.
    """
    if moved > float(variance.mean(dtype=np.float64)) - moved:
        return np.empty((0, 4))
    above = level.ravel() - np.float32(centre)
    flat = variance.ravel()
    first = FIRST * sigma
    rows = [_row(above, flat, (-first, first), frames, moved)]
    # A pixel that is hit in one of n frames has a variance of n times its squared level.
    bright = np.flatnonzero((above > first / RATIO) & (flat <= 0.5 * frames * above**2))
    high, noise = above[bright], flat[bright]
    bins = int(math.log(max(float(above.max()), first) / first) / math.log(RATIO)) + 1
    for low in first * RATIO ** np.arange(bins):
        if np.count_nonzero((high > low) & (high <= RATIO * low)) >= LEAST_PIXELS:
            rows.append(_row(high, noise, (low, RATIO * low), frames, moved))
    found = np.array(rows)
    found[:, 0] += centre
    return found


def _row(
    level: np.ndarray,
    variance: np.ndarray,
    ends: tuple[float, float],
    frames: int,
    moved: float,
) -> list[float]:
    """Mean level; mean variance of the pixels not noisy beyond doubt, its error; pixels.

    Where there are more pixels of lower than of higher levels, noise has brought more of them here
    from below. By Tweedie's formula the level without noise is the measured one and the variance of
    the mean times the slope of the logarithm of the density f; its mean over the pixels between two
    ends is the difference of f over their number (Efron, J. Am. Stat. Assoc. 106, 1602, 2011).
    """
    here = (level > ends[0]) & (level <= ends[1])
    at, own = level[here], variance[here].astype(float)
    freedom = frames - 1
    typical = max(float(np.median(own)), 0.0) * freedom / chi2.median(freedom)
    kept = own <= NOISY * typical * chi2.isf(RARE, freedom) / freedom
    own = own[kept]
    mean = float(own.mean())
    error = max(float(own.std()) / math.sqrt(own.size), UNLIKE * mean, 1e-9)
    error = math.hypot(error, MOVES_UNLIKE * moved)
    still = max(mean - moved, 0.0)
    near = EDGE * (ends[1] - ends[0])
    low, high = (np.count_nonzero(np.abs(level - end) <= near) / (2.0 * near) for end in ends)
    true = float(at[kept].mean()) + still / frames * (high - low) / at.size
    return [true, still, error, float(own.size)]
