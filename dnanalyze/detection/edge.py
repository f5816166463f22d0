"""Where a correction's edge lies: the line x = a max + b that pixels do not cross.

Of all lines the rule's own has the most of the control beyond it for the fewest pixels in their own
rings: a higher one leaves out some of the control, a lower one is crossed by what survived.
"""

from __future__ import annotations

import numpy as np

WEIGHT = 3.0  # of a pixel that crosses, in pixels of the control; sites beside replaced ones do
CANDIDATES = 61


def bound_at(pairs: np.ndarray, slope: float) -> tuple[float, float]:
    """The best b for a slope, DN, and its score: control beyond, less ``WEIGHT`` x pixels beyond.

    Parameters
    ----------
    pairs : ndarray
        (n, 4): pixel, largest of its own ring, larger of two rings on opposite sides along rows,
        along columns; DN above the level from which the rule counts.
    slope : float
    """
    own = np.sort(pairs[:, 0] - slope * pairs[:, 1])[::-1]
    control = np.sort((pairs[:, :1] - slope * pairs[:, 2:]).ravel())
    beyond = (control.size - np.searchsorted(control, own, side="right")) / 2
    score = beyond - WEIGHT * np.arange(own.size)
    best = int(np.argmax(score))
    return float(own[best]), float(score[best])


def tightest_line(pairs: np.ndarray, least: float, most: float) -> tuple[float, float] | None:
    """Slope between ``least`` and ``most``, and bound, DN, of the rule; None without an edge."""
    if not len(pairs):
        return None
    slopes = np.linspace(least, most, CANDIDATES)
    bounds = [bound_at(pairs, a) for a in slopes]
    score = np.array([s for _, s in bounds])
    if not score.max() > 0:
        return None
    best = int(np.median(np.flatnonzero(score == score.max())))
    return float(slopes[best]), bounds[best][0]
