"""What a filter leaves of white noise that was converted to codes, by trial on a small field."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np

FIELD = 96  # pixels a side
TIMES = 0.5, 6.0, 14  # that noise before may be of noise left: the step of a code adds to it


@cache
def _white() -> np.ndarray:
    return np.random.default_rng(1).standard_normal((FIELD, FIELD), np.float32)


def left_of(smooth: Callable[[np.ndarray], np.ndarray], sigma: float) -> np.ndarray:
    """A filtered field of codes of white noise of ``sigma``, DN, without its mean.

    The mean runs over a whole code, since what is left of little noise goes by where it lies.

    Parameters
    ----------
    smooth : callable
        From codes, float32, to codes.
    sigma : float
        DN.

    Returns
    -------
    ndarray
        (FIELD, FIELD), DN.
    """
    white = _white()
    mean = np.linspace(-0.5, 0.5, FIELD, dtype=np.float32)
    return np.asarray(smooth(np.rint(np.float32(sigma) * white + mean)) - mean)


def noise_before(smooth: Callable[[np.ndarray], np.ndarray], noise: float) -> float:
    """Standard deviation of white noise, DN, of which ``noise`` is left, codes' own with it."""
    return reached(
        noise,
        lambda sigma: math.sqrt(float(np.mean(left_of(smooth, sigma) ** 2))),
        (noise * np.geomspace(*TIMES)).tolist(),
    )


def reached(level: float, rise: Callable[[float], float], tried: Sequence[float]) -> float:
    """Where a rise first exceeds a level, between two of the ascending numbers that are tried.

    The last of them where it does not; it is not asked of any beyond.
    """
    rises: list[float] = []
    for x in tried:
        rises.append(rise(x))
        if rises[-1] > level:
            break
    return float(np.interp(level, np.maximum.accumulate(rises), tried[: len(rises)]))


def likeness(field: np.ndarray) -> float:
    """Correlation of neighbours in a row, of a field of mean 0; 0 of an even one."""
    return float(np.mean(field[:, 1:] * field[:, :-1]) / (np.mean(field**2) or 1.0))
