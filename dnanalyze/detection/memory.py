"""Does a pixel remember the frame before: lag-1 autocorrelation over time.

Given the values that a pixel takes in its K frames, in whatever order, E[r1] = -1/K exactly,
whatever their distribution (permutation null). A recursive filter orders them.

Pixels are not independent of one another: what a frame shares (1/f noise where rounding makes each
pixel answer it in its own way, a sensor that warms up) leaves every pair of frames a correlation of
its own, however many pixels there are. So the mean over pairs next to one another is held against
the scatter of pairs that lie equally far apart.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize, stats

from dnanalyze.analyzers.estimators.saturation import CROWDED
from dnanalyze.detection.flatten import centre_and_sd, robust_sd, without_lines, without_tones
from dnanalyze.significance import CLEAR

LEAST_PIXELS = 200  # a correlation in time then scatters by .07 in each pair of frames
LEAST_FRAMES = 6  # for their pairs to say what pixels share
PARTS = 4  # of the frame along a side: a filter acts in all of them
REGULAR = (0.05, 2.5)  # sums of squares of pixels that neither blink nor stay, over the median one
LARGEST_MEMORY = 0.95  # end of the search: a twentieth of each frame is new


@dataclass(frozen=True)
class Autocorrelation:
    """How much a pixel remembers."""

    excess: float  # mean over pixels of r1 + 1/K
    se: float  # its standard error for independent pixels
    # For what pixels of a frame share, and its degrees of freedom: from the scatter of pairs of
    # frames equally far apart; of the parts of the frame where there are too few pairs.
    shared_se: float
    freedom: float
    # What three quarters of 16 parts of the frame exceed: a filter spares none, a glow that drifts
    # spares the other corners.
    everywhere: float
    # Excess once each pixel's straight line in time is taken off, over what that leaves of
    # independent frames, as if it left all of a filter's: a drift has none.
    without_trend: float
    memory: float  # of the recursive filter that explains the excess
    frames: int  # K

    @property
    def p(self) -> float:
        """The larger of both nulls' p-values."""
        if not (self.se > 0 and self.shared_se > 0):
            return 1.0
        alone = float(stats.norm.sf(self.excess / self.se))
        return max(alone, float(stats.t.sf(self.excess / self.shared_se, self.freedom)))


def mean_memory(stacks: Sequence[np.ndarray]) -> Autocorrelation | None:
    """The mean over planes; None where none has an answer."""
    found = [vars(a) for a in map(autocorrelation, stacks) if a is not None]
    if not found:
        return None
    mean = {name: float(np.mean([f[name] for f in found])) for name in found[0]}
    mean["se"] /= math.sqrt(len(found))
    return Autocorrelation(**mean | {"frames": found[0]["frames"]})


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
    regular = (np.abs(pattern) < CLEAR * robust_sd(pattern)) & ~_at_an_end(stack)
    if regular.sum() < LEAST_PIXELS:
        return None
    of_regular = np.where(regular, pattern, np.float32(0))
    power = float((of_regular * of_regular).mean())
    rest = np.empty_like(stack)
    for n, frame in enumerate(stack):
        d = frame - mean
        d = d - np.float32(centre_and_sd(d, 8192)[0])
        slope = np.float32(float((d * of_regular).mean()) / power) if power else np.float32(0)
        rest[n] = without_tones(without_lines(d - slope * pattern))
    squares = (rest * rest).sum(axis=0)
    least, most = (share * np.median(squares) for share in REGULAR)
    keep = regular & (squares > least) & (squares < most)
    if keep.sum() < LEAST_PIXELS:
        return None
    scaled = rest[:, keep] / np.sqrt(squares[keep])
    # what is removed of each frame need not sum to zero over them: the mean over all orders, then,
    # is that over all pairs
    any_order = (scaled.sum(axis=0) ** 2 - 1) / frames
    r1 = np.sum(scaled[1:] * scaled[:-1], axis=0) - any_order
    parts = _parts(r1, keep)
    if frames >= LEAST_FRAMES:
        shared, freedom = _shared(scaled @ scaled.T / r1.size), (frames - 1) * (frames - 2) / 2
    elif parts.size < 2:
        return None  # too few pairs, and too few pixels
    else:
        shared, freedom = float(parts.std(ddof=1)) / math.sqrt(parts.size), parts.size - 1.0
    return Autocorrelation(
        excess=float(r1.mean()),
        se=float(r1.std()) / math.sqrt(r1.size),
        shared_se=shared,
        freedom=freedom,
        everywhere=float(np.quantile(parts, 0.25)),
        without_trend=_without_trend(scaled),
        memory=memory_of(float(np.average(r1, weights=squares[keep])), frames),
        frames=frames,
    )


def _parts(r1: np.ndarray, keep: np.ndarray) -> np.ndarray:
    """Means over parts of the frame that hold enough pixels."""
    y, x = np.nonzero(keep)
    part = y * PARTS // keep.shape[0] * PARTS + x * PARTS // keep.shape[1]
    counts = np.bincount(part, minlength=PARTS**2)
    enough = counts >= min(LEAST_PIXELS // PARTS, counts.max())
    return np.asarray(np.bincount(part, r1, PARTS**2)[enough] / counts[enough])


def _without_trend(series: np.ndarray) -> float:
    """Of (K, n) series, in ratios of sums, over the share that is left of a memory of 20 %."""
    frames = len(series)
    line = np.vander(np.arange(frames), 2)
    rest = np.eye(frames) - line @ np.linalg.pinv(line)

    def excess(products: np.ndarray) -> float:
        left = rest @ products @ rest
        expected = np.diagonal(rest, 1).sum() / np.trace(rest)
        return float(np.diagonal(left, 1).sum() / np.trace(left) - expected)

    share = excess(_covariance(0.2, frames)) / expected_excess(0.2, frames)
    return excess(series @ series.T) / share


def _shared(pairs: np.ndarray) -> float:
    """Standard error of the sum over neighbouring frames, from the scatter along the diagonals of
    the (K, K) mean products of pairs.
    """
    frames = len(pairs)
    own = np.sqrt(np.diag(pairs))
    related = pairs / (own[:, None] * own) if own.all() else pairs
    scatter = sum(lag.var() * lag.size for lag in map(related.diagonal, range(1, frames)))
    freedom = (frames - 1) * (frames - 2) / 2
    return math.sqrt(scatter / freedom * (frames - 1)) / frames


def _at_an_end(stack: np.ndarray) -> np.ndarray:
    """Pixels that reach the highest or lowest code in some frame, where those codes are crowded."""
    highest, lowest = stack.max(axis=0), stack.min(axis=0)
    ends = np.zeros(highest.shape, bool)
    for there in (highest == highest.max(), lowest == lowest.min()):
        if np.count_nonzero(there) > CROWDED:
            ends |= there
    return ends


def _covariance(memory: float, frames: int) -> np.ndarray:
    """Of y_n = (1-a) x_n + a y_(n-1), started at y_0 = x_0, less its mean over the frames."""
    rows = np.zeros((frames, frames))
    rows[0, 0] = 1
    for n in range(1, frames):
        rows[n] = memory * rows[n - 1]
        rows[n, n] += 1 - memory
    rows -= rows.mean(axis=0)
    return rows @ rows.T


def expected_excess(memory: float, frames: int) -> float:
    """r1 + 1/K (ratio of expectations) of a recursive filter."""
    cov = _covariance(memory, frames)
    return float(np.trace(cov[1:, :-1]) / np.trace(cov)) + 1 / frames


def memory_of(excess: float, frames: int) -> float:
    """The memory a that gives this excess; 0 for none."""
    if excess <= 0:
        return 0.0
    if excess >= expected_excess(LARGEST_MEMORY, frames):
        return LARGEST_MEMORY
    return float(
        optimize.brentq(lambda a: expected_excess(a, frames) - excess, 0.0, LARGEST_MEMORY)
    )
