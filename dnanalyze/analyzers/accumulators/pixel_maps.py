"""What is kept of each pixel over the frames: sums, products, extremes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from dnanalyze.analyzers.kernels.layout import BATCH
from dnanalyze.analyzers.plan import CLIP, TAIL_CLIP, FrameView, Plan

HOT_SIGMAS = 5.0
BLINK_CUT = 64.0  # squared differences are cut at this many times their scale


@dataclass(frozen=True)
class Maps:
    """What is known of each pixel at the end, (rows, columns); float32, DN, unless said otherwise.

    Parameters
    ----------
    mean : ndarray
        Mean over the frames.
    variance : ndarray
        Unbiased variance over the frames, DN^2; 0 for one frame.
    lag_one : ndarray
        Autocovariance at one frame about the pixel's mean, times the frames, DN^2.
    pair_squares : tuple of ndarray
        Sums of cut squared differences over two disjoint sets of frame pairs, DN^2.
    high, low : ndarray
        Largest and smallest value.
    high_at : ndarray of int32
        The frame that holds the largest.
    head, tail : list of ndarray
        The first two frames, the last two; fewer for few frames.
    scalars : ndarray
        A row for each frame, see `pixel_loops.add_frames`; the last column is its shift.
    cumulants : ndarray
        Second and third within three successive frames, DN^2 and DN^3, (triples, 2); see
        `cumulants_of`.
    hot_limit : float
        Level above which a pixel of a frame that has not moved counts as hot.
    """

    mean: np.ndarray
    variance: np.ndarray
    lag_one: np.ndarray
    pair_squares: tuple[np.ndarray, np.ndarray]
    high: np.ndarray
    high_at: np.ndarray
    low: np.ndarray
    head: list[np.ndarray]
    tail: list[np.ndarray]
    scalars: np.ndarray
    hot_limit: float
    cumulants: np.ndarray

    @property
    def shifts(self) -> np.ndarray:
        """By how much the level of each frame has moved from the plan's centre, DN; (frames,)."""
        return self.scalars[:, -1]


class PixelMaps:
    """Per-pixel sums over the frames, and the frame sums that cost nothing beside them.

    Attributes are complete after `flush`. Sums are of the value less ``origin``, float64.
    ``scalars`` has a row for each frame, see `pixel_loops.add_frames`, which ends with the shift
    of its level (`FrameView`). ``head`` and ``tail`` hold
    the first two and the last two frames, for what needs independent pairs.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.frames = 0
        self.origin = float(round(plan.centre) if plan.integer else np.float32(plan.centre))
        self.head: list[np.ndarray] = []
        self.tail: list[np.ndarray] = []
        self.scalars = np.empty((0, 8))
        self.cumulants = np.empty((0, 2))
        self._waiting: list[np.ndarray] = []
        self._shifts: list[float] = []
        self._last: np.ndarray | None = None
        self._start = 0
        self._sums: tuple[np.ndarray, ...] | None = None

    def add(self, view: FrameView) -> None:
        """Take in the next frame."""
        if not self.frames:
            self._start = view.number
        self.frames += 1
        if len(self.head) < 2:
            self.head.append(view.frame)
        if len(self.tail) == 2:
            one, two = self.tail
            here = cumulants_of(self.plan, one, two, view.frame)
            self.cumulants = np.concatenate([self.cumulants, here])
        self.tail = [*self.tail[-1:], view.frame]
        self._waiting.append(view.frame)
        self._shifts.append(view.shift)
        if len(self._waiting) == BATCH:
            self.flush()

    def flush(self) -> None:
        """Bring the sums up to date."""
        if self._waiting:
            self._add(self._waiting)
            self._last = self._waiting[-1]
            self._waiting, self._shifts = [], []

    def merge(self, later: Self, seam: FrameView) -> None:
        """Take in the frames that follow mine."""
        from dnanalyze.analyzers.kernels import pixel_loops

        self.flush()
        later.flush()
        mine, last = self._arrays(), self._last
        assert last is not None
        before = last.ravel().astype(float) - self.origin
        here = seam.frame.ravel().astype(float) - self.origin
        for k in (0, 1, 2, 3, 4):
            mine[k][:] += later._arrays()[k]
        mine[2][:] += before * here
        if seam.number % 2:
            pairs = mine[3] if seam.number % 4 == 1 else mine[4]
            pairs += np.minimum((here - before) ** 2, self._blink_limit)
        high, high_at, low = mine[5:]
        more = later._arrays()[5] > high
        high[more] = later._arrays()[5][more]
        high_at[more] = later._arrays()[6][more]
        np.minimum(low, later._arrays()[7], out=low)
        first = later.scalars[0].copy()
        first[2] = first[4] = first[5] = 0
        pixel_loops.seam_sums(
            seam.frame.ravel(), last.ravel(), self.plan.centre + first[-1],
            self.plan.centre + self.scalars[-1, -1], CLIP * self.plan.sigma,
            HOT_SIGMAS * self.plan.sigma, first,
        )  # fmt: skip
        self.scalars = np.concatenate([self.scalars, first[None], later.scalars[1:]])
        near = [*self.tail, *later.head]
        across = [cumulants_of(self.plan, *near[k : k + 3]) for k in range(len(near) - 2)]
        self.cumulants = np.concatenate([self.cumulants, *across, later.cumulants])
        self.head = [*self.head, *later.head][:2]
        self.tail = [*self.tail, *later.tail][-2:]
        self.frames += later.frames
        self._last = later._last

    def finish(self) -> Maps:
        """The maps; they take the place of the sums, to which nothing can be added any more."""
        from dnanalyze.analyzers.kernels import pixel_loops

        (total, square, lag, *pairs, high, high_at, low), self._sums = self._arrays(), None
        shape = self.plan.shape
        moments = np.empty((3, total.size), np.float32)
        first, last = self.head[0].ravel(), self.tail[-1].ravel()
        pixel_loops.moments(total, square, lag, first, last, self.origin, self.frames, *moments)
        del total, square, lag
        mean, variance, lag_one = moments.reshape(3, *shape)
        one = pairs.pop(0).astype(np.float32)
        other = pairs.pop(0).astype(np.float32)
        return Maps(
            self.head[0] if self.frames == 1 else mean,
            variance,
            lag_one,
            (one.reshape(shape), other.reshape(shape)),
            high.reshape(shape),
            high_at.reshape(shape),
            low.reshape(shape),
            self.head,
            self.tail,
            self.scalars,
            self.hot_limit,
            self.cumulants,
        )

    @property
    def _blink_limit(self) -> float:
        return BLINK_CUT * 2.0 * self.plan.difference_sigma**2

    @property
    def hot_limit(self) -> float:
        """Level above which a pixel of a frame counts as hot, DN."""
        return self.plan.centre + HOT_SIGMAS * self.plan.sigma

    def _arrays(self) -> tuple[np.ndarray, ...]:
        self.flush()
        assert self._sums is not None
        return self._sums

    def _add(self, frames: list[np.ndarray]) -> None:
        from dnanalyze.analyzers.kernels import pixel_loops

        plan = self.plan
        n = plan.pixels
        flat = [f.ravel() for f in frames]
        scalars = np.zeros((len(flat), 8))
        scalars[0, 5] = self._last is None
        scalars[:, -1] = self._shifts
        last = self.scalars[-1:, -1] if len(self.scalars) else np.zeros(1)
        centres = plan.centre + np.append(last, scalars[:, -1])
        if self._last is None:
            sums = [np.zeros(n) for _ in range(5)]
            extremes = [np.full(n, -np.inf, np.float32), np.zeros(n, np.int32)]
            self._sums = (*sums, *extremes, np.full(n, np.inf, np.float32))
            before = np.full(n, self.origin, np.float32)
        else:
            before = self._last.ravel()
        assert self._sums is not None
        total, square, lag, first_pairs, second_pairs, high, high_at, low = self._sums
        done = len(self.scalars)
        pixel_loops.add_frames(
            tuple(flat + flat[:1] * (BATCH - len(flat))), len(flat), self._start + done, before,
            self.origin, centres.astype(np.float32), CLIP * plan.sigma, self._blink_limit,
            HOT_SIGMAS * plan.sigma,
            total, square, lag, first_pairs, second_pairs, high, high_at, low, scalars,
        )  # fmt: skip
        self.scalars = np.concatenate([self.scalars, scalars])


def cumulants_of(plan: Plan, one: np.ndarray, two: np.ndarray, three: np.ndarray) -> np.ndarray:
    """Unbiased second and third cumulant of three successive frames, mean of the pixels; (1, 2).

    DN^2 and DN^3. The level may move from frame to frame; what single pixels move by is cut, so
    that a hit is no skewness of the noise.
    """
    from dnanalyze.analyzers.kernels import pixel_loops

    cut = TAIL_CLIP * math.sqrt(2.0) * plan.difference_sigma
    few = [plan.sample(frame) for frame in (one, two, three)]
    first, second = _move(few[1] - few[0], cut), _move(few[2] - few[1], cut)
    sums = np.zeros((1, 2))
    pixel_loops.cumulants(one.ravel(), two.ravel(), three.ravel(), first, second, cut, sums[0])
    return sums / plan.pixels


def _move(sample: np.ndarray, cut: float) -> float:
    """By how much the level moves, DN, from differences of an even sample of the pixels."""
    middle = np.median(sample)
    return float(middle + np.clip(sample - middle, -cut, cut).mean(dtype=np.float64))
