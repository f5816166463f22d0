"""The streaming pass: each accumulator sees every frame once, memory holds a few frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np

from dnanalyze.analyzers.accumulators.accumulated import Accumulated, Accumulator
from dnanalyze.analyzers.accumulators.histograms import Histograms
from dnanalyze.analyzers.accumulators.neighbour_sums import Neighbours
from dnanalyze.analyzers.accumulators.pixel_maps import PixelMaps
from dnanalyze.analyzers.estimators.quantiles import Ordered, median
from dnanalyze.analyzers.plan import FrameView, Plan
from dnanalyze.analyzers.spectra.spectral_sums import Spectra
from dnanalyze.analyzers.streaming.buffers import Buffers

# the longest first, so that the others run beside it
ACCUMULATORS: dict[str, Callable[[Plan], Accumulator]] = {
    "spectra": Spectra,
    "neighbours": Neighbours,
    "maps": PixelMaps,
    "histograms": Histograms,
}
SERVES = {"spectra": ("spectrum", "lines"), "neighbours": ("neighbours",)}  # the others serve all
BAND = 1 << 16  # pixels that are worked on together, in the cache
HALF = np.float32(np.sqrt(0.5))


def make_plan(
    first: np.ndarray,
    second: np.ndarray | None = None,
    errors: bool = True,
    families: tuple[str, ...] = (),
) -> Plan:
    """The scales of a setting from its first frame, or two, (rows, columns) in DN."""
    frame = as_float(first)
    integer = first.dtype.kind in "ui" or bool(np.all(frame == np.rint(frame)))
    ordered = Ordered(frame, 1.0 if integer else 0.0)
    sigma = ordered.robust_sigma()
    between = sigma
    if second is not None:
        difference = (as_float(second) - frame) * HALF
        between = Ordered(difference, float(HALF) if integer else 0.0).robust_sigma()
    low, high = float(ordered.sorted[0]), float(ordered.sorted[-1])
    centre = float(ordered.quantile(0.5))
    return Plan(frame.shape, centre, sigma, between, low, high, integer, errors, families)


def as_float(frame: np.ndarray) -> np.ndarray:
    """C-contiguous float32."""
    return np.ascontiguousarray(frame, np.float32)


def make_view(
    plan: Plan,
    number: int,
    raw: np.ndarray,
    before: np.ndarray | None,
    buffers: Buffers | None = None,
) -> FrameView:
    """What the accumulators see of a frame as read; ``before`` is the frame before it, float32.

    A frame that is float32 already is taken as it is.
    """
    buffers = buffers or Buffers()
    ready = raw.dtype == np.float32 and raw.flags.carray
    frame = raw if ready else buffers.take(raw.shape)
    difference = None if before is None else buffers.take(raw.shape)
    step = max(1, BAND // raw.shape[1])
    for top in range(0, raw.shape[0], step):
        rows = slice(top, top + step)
        if not ready:
            np.copyto(frame[rows], raw[rows], casting="unsafe")
        if before is not None and difference is not None:
            part = np.subtract(frame[rows], before[rows], out=difference[rows])
            part *= HALF
    return FrameView(number, frame, difference, plan, _shift(plan, frame))


def _shift(plan: Plan, frame: np.ndarray) -> float:
    """See `FrameView`; a cut at 6 sigma loses nothing by a centre that is off by one."""
    moved = median(plan.sample(frame)) - plan.centre
    return moved if abs(moved) > plan.sigma else 0.0


class Accumulation:
    """The accumulators of one setting (and plane and window), fed frame by frame.

    Parameters
    ----------
    plan : Plan
    pool : ThreadPoolExecutor, optional
        Accumulators then run in its threads, each seeing the frames in order.
    """

    def __init__(self, plan: Plan, pool: ThreadPoolExecutor | None = None) -> None:
        self.plan = plan
        self.frames = 0
        self.parts: dict[str, Any] = {
            name: make(plan)
            for name, make in ACCUMULATORS.items()
            if plan.wants(*SERVES.get(name, plan.families))
        }
        self._pool = pool
        self._running: dict[str, Future[None]] = {}
        self._buffers = Buffers()
        self.first: FrameView | None = None
        self.last: np.ndarray | None = None

    def add(self, raw: np.ndarray, number: int) -> None:
        """Take in the next frame as read."""
        view = make_view(self.plan, number, raw, self.last, self._buffers)
        self.first = self.first or view
        self.last = view.frame
        self.frames += 1
        for name, part in self.parts.items():
            if self._pool is None:
                part.add(view)
                continue
            if name in self._running:
                self._running[name].result()
            self._running[name] = self._pool.submit(part.add, view)

    def __getstate__(self) -> dict[str, Any]:
        """As it travels between machines: complete, and without threads and idle buffers."""
        self.wait()
        for part in self.parts.values():
            getattr(part, "flush", lambda: None)()
        return vars(self) | {"_pool": None, "_buffers": Buffers()}

    def wait(self) -> None:
        """Until every accumulator has seen every frame."""
        for running in self._running.values():
            running.result()
        self._running = {}

    def merge(self, later: Accumulation) -> None:
        """Take in the frames that follow mine; both must have been made with the same plan."""
        self.wait()
        later.wait()
        assert later.first is not None
        seam = make_view(self.plan, later.first.number, later.first.frame, self.last)
        for name, part in self.parts.items():
            part.merge(later.parts[name], seam)
        self.frames += later.frames
        self.last = later.last

    def finish(self) -> Accumulated:
        """What the families work on; nothing can be added any more."""
        self.wait()
        self._buffers = Buffers()
        maps = self.parts["maps"].finish()
        others: dict[str, Any] = {
            name: self.parts.get(name) or make(self.plan)
            for name, make in ACCUMULATORS.items()
            if name != "maps"
        }
        means = maps.scalars[:, 0] / self.plan.pixels + maps.shifts
        return Accumulated(self.plan, self.frames, means, maps, **others)


def read_ahead(reads: Iterable[Callable[[], np.ndarray]]) -> Iterable[np.ndarray]:
    """The results of ``reads`` in order, the next one being read in a thread of its own."""
    with ThreadPoolExecutor(1) as reader:
        waiting: Future[np.ndarray] | None = None
        for read in reads:
            following = reader.submit(read)
            if waiting is not None:
                yield waiting.result()
            waiting = following
        if waiting is not None:
            yield waiting.result()


def accumulate(
    frames: Sequence[np.ndarray], plan: Plan | None = None, start: int = 0
) -> Accumulation:
    """Accumulate frames that are at hand, (rows, columns) each; ``start`` numbers the first."""
    if plan is None:
        plan = make_plan(frames[0], frames[1] if len(frames) > 1 else None)
    out = Accumulation(plan)
    for number, frame in enumerate(frames, start):
        out.add(frame, number)
    return out
