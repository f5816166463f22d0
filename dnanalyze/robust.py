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
