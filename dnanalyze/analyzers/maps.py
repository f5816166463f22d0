"""What is kept of each pixel over the frames: sums, products, extremes."""

from __future__ import annotations

from typing import Self

import numpy as np

from dnanalyze.analyzers.plan import CLIP, FrameView, Plan

BATCH = 4  # frames that go over the sums together, to spare memory traffic
HOT_SIGMAS = 5.0
BLINK_CUT = 64.0  # squared differences are cut at this many times their scale


class PixelMaps:
    """Per-pixel sums over the frames, and the frame sums that cost nothing beside them.

    Attributes are complete after `flush`. Sums are of the value less ``origin``, float64.
    ``scalars`` has a row for each frame, see `kernels.add_frames`. ``ends`` holds the first two and
    the last two frames, for what needs independent pairs.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.frames = 0
        self.origin = float(round(plan.centre) if plan.integer else np.float32(plan.centre))
        self.head: list[np.ndarray] = []
        self.tail: list[np.ndarray] = []
        self.scalars = np.empty((0, 6))
        self._waiting: list[np.ndarray] = []
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
        self.tail = [*self.tail[-1:], view.frame]
        self._waiting.append(view.frame)
        if len(self._waiting) == BATCH:
            self.flush()

    def flush(self) -> None:
        """Bring the sums up to date."""
        if self._waiting:
            self._add(self._waiting)
            self._last = self._waiting[-1]
            self._waiting = []

    def merge(self, later: Self, seam: FrameView) -> None:
        """Take in the frames that follow mine."""
        from dnanalyze.analyzers import kernels

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
        kernels.seam_sums(
            seam.frame.ravel(), last.ravel(), self.plan.centre, CLIP * self.plan.sigma,
            self.hot_limit, first,
        )  # fmt: skip
        self.scalars = np.concatenate([self.scalars, first[None], later.scalars[1:]])
        self.head = [*self.head, *later.head][:2]
        self.tail = [*self.tail, *later.tail][-2:]
        self.frames += later.frames
        self._last = later._last

    def frame_scalars(self) -> np.ndarray:
        """A row for each frame, see `kernels.add_frames`."""
        self.flush()
        return self.scalars

    def moments(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """`mean`, `variance` and `lag_one`, in one pass over the sums."""
        from dnanalyze.analyzers import kernels

        total, square, lag = self._arrays()[:3]
        out = np.empty((3, self.plan.pixels), np.float32)
        ends = self.head[0].ravel(), self.tail[-1].ravel()
        kernels.moments(total, square, lag, *ends, self.origin, self.frames, *out)
        mean = self.head[0] if self.frames == 1 else self._map(out[0])
        return mean, self._map(out[1]), self._map(out[2])

    def mean(self) -> np.ndarray:
        """Mean over the frames, DN, float32."""
        return self.moments()[0]

    def variance(self) -> np.ndarray:
        """Unbiased variance over the frames, DN^2, float32; 0 for one frame."""
        return self.moments()[1]

    def lag_one(self) -> np.ndarray:
        """Autocovariance at one frame about the pixel's mean, times the frames, DN^2, float32."""
        return self.moments()[2]

    def extremes(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Largest value of each pixel, DN, the frame that holds it, and the smallest value."""
        high, high_at, low = self._arrays()[5:]
        return self._map(high), high_at.reshape(self.plan.shape), self._map(low)

    def pair_squares(self) -> tuple[np.ndarray, np.ndarray]:
        """Sums of cut squared differences over two disjoint sets of frame pairs, DN^2, float32."""
        return self._map(self._arrays()[3]), self._map(self._arrays()[4])

    @property
    def _blink_limit(self) -> float:
        return BLINK_CUT * 2.0 * self.plan.difference_sigma**2

    @property
    def hot_limit(self) -> float:
        """Level above which a pixel of a frame counts as hot, DN."""
        return self.plan.centre + HOT_SIGMAS * self.plan.sigma

    def _map(self, flat: np.ndarray) -> np.ndarray:
        return flat.astype(np.float32, copy=False).reshape(self.plan.shape)

    def _arrays(self) -> tuple[np.ndarray, ...]:
        self.flush()
        assert self._sums is not None
        return self._sums

    def _add(self, frames: list[np.ndarray]) -> None:
        from dnanalyze.analyzers import kernels

        plan = self.plan
        n = plan.pixels
        if self._sums is None:
            sums = [np.zeros(n) for _ in range(5)]
            extremes = [np.full(n, -np.inf, np.float32), np.zeros(n, np.int32)]
            self._sums = (*sums, *extremes, np.full(n, np.inf, np.float32))
        total, square, lag, first_pairs, second_pairs, high, high_at, low = self._sums
        flat = [f.ravel() for f in frames]
        scalars = np.zeros((len(flat), 6))
        scalars[0, 5] = self._last is None
        if self._last is None:
            before = np.full(n, self.origin, np.float32)
        else:
            before = self._last.ravel()
        done = len(self.scalars)
        kernels.add_frames(
            tuple(flat + flat[:1] * (BATCH - len(flat))), len(flat), self._start + done, before,
            self.origin, plan.centre, CLIP * plan.sigma, self._blink_limit, self.hot_limit,
            total, square, lag, first_pairs, second_pairs, high, high_at, low, scalars,
        )  # fmt: skip
        self.scalars = np.concatenate([self.scalars, scalars])
