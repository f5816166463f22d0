"""Does the tail of pixels that stand out end more sharply than clusters of hot pixels can end it?

A correction empties all beyond a line x = a max + b of the plane of a pixel and the largest of its
neighbours, and nothing below it. Clusters thin a broad region of that plane: the share of pixels
that stand out of their own ring, among those that stand out of rings elsewhere, falls smoothly with
the bound, by a power of it (a hot pixel with k hot neighbours) or like a Gaussian (neighbours as
hot as the pixel). So what is left beyond a bound is held against two steps of the tail just below,
carried on: own counts as a Gaussian or a slower tail would go on, and the share of the control
likewise. The lesser of both is the least that hot pixels leave, however they are clustered.
"""

from __future__ import annotations

import numpy as np

from dnanalyze.detection.excess import Excess

STEP = 1.25  # ratio of bounds between steps of the tail
BEYOND = 2.0  # times the bound, up to where what is left is counted
# ln of the counts of a Gaussian tail falls by STEP^2 = 1.6 times as much in the next step: below 2
CARRIED = 2.0
# the middle of (b, 2 b) lies two steps above that of (b / 1.25, b), each up to 1.6 as steep
CARRIED_SHARE = 3.0
SAFE = 0.5  # of that is expected: clusters of 60 laws (density, size, reach, amplitude) left .2


def tail(top: Excess) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of the counts beyond a ladder of bounds, for each bound: pixels of a frame between it and
    ``BEYOND`` times it; the least that clusters leave there; whether both steps below are shown.
    """
    bounds = top.bounds
    here = np.arange(bounds.size)
    lower, low = (np.searchsorted(bounds, bounds / STEP**n) for n in (2, 1))
    high = np.minimum(np.searchsorted(bounds, BEYOND * bounds), bounds.size - 1)

    def steps(counts: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        a_frame = counts / top.frames
        return a_frame[lower] - a_frame[low], a_frame[low] - a_frame, a_frame - a_frame[high]

    first, second, left = steps(top.own)
    share_first, share = _over(first, steps(top.control)[0]), _over(second, steps(top.control)[1])
    carried = second * np.minimum(1.0, _over(second, first)) ** CARRIED
    fall = np.minimum(1.0, _over(share, share_first)) ** CARRIED_SHARE
    rings = steps(top.control)[2] * np.minimum(1.0, share) * fall
    shown = (lower < low) & (low < here) & (bounds >= bounds[0] * STEP**2) & (first > 0)
    return left, SAFE * np.minimum(carried, rings), shown


def _over(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(a / np.maximum(b, 1e-9))
