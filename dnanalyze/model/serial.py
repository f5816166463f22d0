"""Normal deviates that are correlated with the one before and the one before that."""

from __future__ import annotations

import numpy as np


def moving_average(first: float, second: float) -> np.ndarray:
    """Weights of the present and the earlier deviates for correlations at lags 1 and 2.

    The factor 1 + b_1 z + b_2 z^2 of 1 + r_1 (z + 1/z) + r_2 (z^2 + 1/z^2) whose roots lie outside
    the unit circle. Correlations that no noise can have together are made smaller in proportion.
    """
    wave = 2.0 * np.pi * np.linspace(0.0, 0.5, 257)
    deepest = float(np.min(2.0 * first * np.cos(wave) + 2.0 * second * np.cos(2.0 * wave)))
    first, second = np.array([first, second]) * min(1.0, 0.99 / max(-deepest, 1e-9))
    roots = np.roots([second, first, 1.0, first, second])
    inside = roots[np.abs(roots) < 1.0]
    weights = np.real(np.poly(inside))
    return weights / np.linalg.norm(weights)


def averaged(white: np.ndarray, weights: np.ndarray, begins: bool) -> np.ndarray:
    """White deviates mixed along the last axis, float32, of unit variance.

    Parameters
    ----------
    white : ndarray
        With as many deviates before the wanted ones as there are earlier weights, fewer where the
        line begins.
    weights : ndarray
        Of the present deviate and of the earlier ones.
    begins : bool
        Whether the first deviates are the first of the line: these have none, or one, before them.
    """
    mixed = white * np.float32(weights[0])
    for lag in range(1, weights.size):
        mixed[..., lag:] += np.float32(weights[lag]) * white[..., :-lag]
    if begins:
        for place in range(weights.size - 1):
            mixed[..., place] /= np.float32(np.linalg.norm(weights[: place + 1]))
    return np.asarray(mixed)


def sizes(text: str) -> tuple[int, int]:
    """The two numbers of a choice such as 4x2."""
    first, second = text.split("x")
    return int(first), int(second)


def groups(lines: np.ndarray, together: str) -> np.ndarray:
    """Number of the group of each line, of n x m lines.

    m banks take the lines in turn; n lines of a bank that follow each other are one group.
    """
    rows, banks = sizes(together)
    return np.asarray(lines // (rows * banks) * banks + lines % banks)
