"""Spread of the bulk of a distribution, whatever its tails."""

from __future__ import annotations

import numpy as np

QUARTILES = (
    1.349  # 2 Phi^-1(3/4): between the quartiles of a normal distribution, standard deviations
)
MAD = 1.4826  # 1 / Phi^-1(3/4): from the median absolute deviation to a normal standard deviation


def robust_deviation(values: np.ndarray, centre: float | None = None) -> float:
    """Standard deviation of normal values by their median absolute deviation.

    Parameters
    ----------
    values : ndarray
        Of any shape; one at least.
    centre : float, optional
        From which deviations are taken; the median by default.

    Examples
    --------
    >>> import numpy as np
    >>> robust_deviation(np.array([1.0, 2.0, 3.0, 4.0, 900.0]))
    1.4826
    """
    middle = np.median(values) if centre is None else centre
    return float(MAD * np.median(np.abs(values - middle)))


def core_deviation(values: np.ndarray) -> float:
    """Standard deviation of normal values by their quartiles, also of rounded values.

    The quartiles are those of grouped data: each value stands for what lies nearer to it than to
    its neighbours. Those of a sample of few codes are codes, and may be the same one.

    Parameters
    ----------
    values : ndarray
        Of any shape; one at least.

    Returns
    -------
    float
        0 where all values are the same.

    Examples
    --------
    >>> import numpy as np
    >>> round(core_deviation(np.array([8.0, 8.0, 8.0, 8.0, 8.0, 8.0, 8.0, 9.0, 9.0, 7.0])), 2)
    0.53
    """
    codes, counts = np.unique(values, return_counts=True)
    if codes.size == 1:
        return 0.0
    between = (codes[1:] + codes[:-1]) / 2.0
    edges = np.array([2.0 * codes[0] - between[0], *between, 2.0 * codes[-1] - between[-1]])
    below = np.append(0.0, np.cumsum(counts)) / counts.sum()
    low, high = np.interp((0.25, 0.75), below, edges)
    return float(high - low) / QUARTILES
