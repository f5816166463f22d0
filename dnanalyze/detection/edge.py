"""Where a correction's edge lies: the line x = a max + b that pixels do not cross.

The slope of the ladder at which the tail ends most abruptly tells the rule coarsely. Between the
steps of the ladder the rule's own line has the most of the control beyond it for the fewest pixels
in their own rings: a higher one leaves out some of the control, a lower one is crossed by what
survived.
"""

from __future__ import annotations

import numpy as np

from dnanalyze.detection.excess import LADDER, SLOPES, Excess, StandingOut
from dnanalyze.significance import NOTICEABLE, SIGN

WEIGHT = 3.0  # of a pixel that crosses, in pixels of the control; sites beside replaced ones do
CANDIDATES = 61  # slopes, 0.1 apart over the widest range of a rule, from 4 to 10
LEFT = 0.05  # share of the tail that is nothing
FEW = 5.0  # pixels, or sites, below which chance decides how many there are
RUNG = float(LADDER[-1] / LADDER[-2]) - 1.0  # of a bound: a step of the ladder


def coarse_line(out: StandingOut, noise: float) -> tuple[float, float] | None:
    """Slope and bound of the rule (DN above the base); None where the tail ends nowhere abruptly.

    Below the rule's own slope the bound falls as fast as the hottest survivors' neighbours are
    hot; above it only as fast as neighbours rise above the base by noise.
    """
    bounds = [_end(out.along(slope), noise) for slope in SLOPES]
    for k, slope in enumerate(SLOPES[:-1]):
        quiet = NOTICEABLE * noise * (SLOPES[k + 1] - slope)  # no quiet neighbour rises by more
        if np.isfinite(bounds[k]) and bounds[k] - bounds[k + 1] <= quiet + RUNG * bounds[k]:
            return slope, bounds[k]
    return None


def _end(top: Excess, noise: float) -> float:
    """The least bound, DN, beyond which (almost) nothing is left of a tail that is still there
    elsewhere; infinite: none.
    """
    ends = (top.own < LEFT * top.control) & (top.control >= FEW * top.frames)
    ends &= top.bounds >= SIGN * noise
    return float(top.bounds[ends][0]) if ends.any() else np.inf


def edge(top: Excess, j: int) -> float:
    """The smallest bound beyond which (almost) nothing is left, from the ``j``-th down."""
    empty = top.own <= LEFT * top.control
    while j > 0 and empty[j - 1] and top.control[j - 1] > 0:
        j -= 1
    return float(top.bounds[j])


def bound_at(pairs: np.ndarray, slope: float) -> tuple[float, float]:
    """The best b for a slope, DN, and its score: control beyond, less ``WEIGHT`` x pixels beyond.

    ``pairs``: (n, 4), pixels with their own and two displaced rings as in `StandingOut`, DN above
    the level from which the rule counts.
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
