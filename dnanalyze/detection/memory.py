"""Does a pixel remember the frame before: lag-1 autocorrelation over time.

Given the values that a pixel takes in its K frames, in whatever order, E[r1] = -1/K exactly,
whatever their
distribution (permutation null). A recursive filter orders them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import optimize

from dnanalyze.detection.flatten import centre_and_sd, robust_sd, without_lines, without_tones

LEAST_PIXELS = 200


@dataclass(frozen=True)
class Autocorrelation:
    """Mean over pixels of r1 + 1/K, its standard error, and the recursive memory that explains
    it.
    """

    excess: float
    se: float
    memory: float
    frames: int


def autocorrelation(stack: np.ndarray) -> Autocorrelation | None:
    """From the frames of one setting in their order; None for fewer than 4 or where nothing varies.

    Frame offsets, lines, and a growth of the whole pattern (a sensor that warms up) are removed;
    pixels that vary much more than most (blinking ones) are left out, which keeps the null.
    """
    frames = stack.shape[0]
    if frames < 4:
        return None
    mean = stack.mean(axis=0)
    pattern = mean - np.median(mean)
    ordinary = (np.abs(pattern) < 5 * robust_sd(pattern)) & ~_at_an_end(stack)
    if ordinary.sum() < LEAST_PIXELS:
        return None
    pattern_here = np.where(ordinary, pattern, np.float32(0))
    power = float((pattern_here * pattern_here).mean())
    second = None
    squares = np.zeros_like(mean)
    products = np.zeros_like(mean)
    for frame in stack:
        d = frame - mean
        d = d - np.float32(centre_and_sd(d, 8192)[0])
        slope = np.float32(float((d * pattern_here).mean()) / power) if power else np.float32(0)
        reach = np.float32(4 * centre_and_sd(d - slope * pattern, 8192)[1])
        d = without_lines(d - slope * pattern)
        tones = np.clip(d, -reach, reach)
        d = d - (tones - without_tones(tones))
        squares = squares + d * d
        if second is not None:
            products = products + d * second
        second = d
    typical = np.median(squares)
    if typical <= 0:
        return None
    keep = ordinary & (squares > 0.05 * typical) & (squares < 2.5 * typical)
    if keep.sum() < LEAST_PIXELS:
        return None
    r1 = products[keep] / squares[keep]
    value = float(r1.mean()) + 1 / frames
    return Autocorrelation(
        value, float(r1.std() / np.sqrt(r1.size)), memory_of(value, frames), frames
    )


def _at_an_end(stack: np.ndarray) -> np.ndarray:
    """Pixels that reach the highest or lowest code in some frame, where those codes are crowded."""
    highest, lowest = stack.max(axis=0), stack.min(axis=0)
    ends = np.zeros(highest.shape, bool)
    for extreme, end in ((highest, highest.max()), (lowest, lowest.min())):
        there = extreme == end
        if np.count_nonzero(there) > 20:
            ends |= there
    return ends


def expected_excess(memory: float, frames: int) -> float:
    """r1 + 1/K (ratio of expectations) of y_n = (1-a) x_n + a y_(n-1), started at y_0 = x_0."""
    rows = np.zeros((frames, frames))
    rows[0, 0] = 1
    for n in range(1, frames):
        rows[n] = memory * rows[n - 1]
        rows[n, n] += 1 - memory
    rows -= rows.mean(axis=0)
    cov = rows @ rows.T
    return float(np.trace(cov[1:, :-1]) / np.trace(cov)) + 1 / frames


def memory_of(excess: float, frames: int) -> float:
    """The memory a that gives this excess; 0 for none."""
    top = 0.95
    if excess <= 0:
        return 0.0
    if excess >= expected_excess(top, frames):
        return top
    return float(optimize.brentq(lambda a: expected_excess(a, frames) - excess, 0.0, top))
