"""The spread of random values beyond their chance scatter, by maximum likelihood."""

from __future__ import annotations

import math

import numpy as np
from scipy import optimize


def random_size(values: np.ndarray, chance: np.ndarray | float) -> tuple[float, float, float]:
    """Variance A^2 of values x ~ N(0, chance + A^2), its standard error, and what it explains.

    Parameters
    ----------
    values : ndarray
        Of any shape.
    chance : ndarray or float
        Variance of each by chance.

    Returns
    -------
    tuple of float
        A^2, its standard error, twice the gain of the log likelihood over A = 0.
    """
    x2 = np.asarray(values, float).ravel() ** 2
    c = np.broadcast_to(np.asarray(chance, float), np.shape(values)).ravel()
    scale = float(np.mean(c))
    most = 4.0 * float(np.mean(x2)) / scale + 1.0

    def cost(size: float) -> float:
        whole = c + size * scale
        return float(np.sum(np.log(whole) + x2 / whole))

    found = optimize.minimize_scalar(
        cost, bounds=(0.0, most), method="bounded", options={"xatol": 1e-9 * most}
    )
    size, gain = float(found.x) * scale, cost(0.0) - float(found.fun)
    information = 0.5 * float(np.sum(1.0 / (c + size) ** 2))
    return max(size, 0.0), 1.0 / math.sqrt(information), max(gain, 0.0)
