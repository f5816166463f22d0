"""The streaming pass on a Dask cluster: runs of frames on the workers, merged in order here.

What is merged so far is saved now and then, and when the run is interrupted, so that the next run
goes on from there. Dask gives the work of a worker that dies to another one.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.analyzers.plan import Plan
from dnanalyze.analyzers.streaming import saved_accumulation
from dnanalyze.analyzers.streaming.accumulation import Accumulation, make_plan
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Frame, Window

RUN = 64  # frames at most that a worker takes at a time
AHEAD = 2  # runs a worker that wait to be merged, or to be begun
SAVED_EVERY = 30.0  # seconds
TIMEOUT = 20.0  # seconds to reach a scheduler


class Cut:
    """How a frame is cut into what is analysed each by itself; `Cut.of` is pure and picklable."""

    def __init__(self, outer: Window, parts: Sequence[Any]) -> None:
        self.outer, self.parts = outer, tuple(parts)

    def of(self, frame: Frame) -> list[np.ndarray]:
        """The pixels of every window and colour plane."""
        pixels = frame.read(self.outer)
        if pixels.shape != self.outer.shape:
            raise InputError(
                f"{frame.name}: its shape is not that of the other frames; "
                "give the frames of each shape a folder of their own"
            )
        return [part.cut(pixels, self.outer) for part in self.parts]


def plans(first: Sequence[Frame], cut: Cut) -> list[Plan]:
    """The plan of every part, from the first two frames, or the only one."""
    seen = [cut.of(frame) for frame in first[:2]]
    second: list[Any] = seen[1] if len(seen) > 1 else [None] * len(seen[0])
    triples = zip(seen[0], second, cut.parts, strict=True)
    return [make_plan(a, b, part.errors, part.families) for a, b, part in triples]


def accumulated(
    frames: Sequence[Frame], cut: Cut, made: Sequence[Plan], start: int
) -> list[Accumulation]:
    """Every part of a run of frames, the first of which has the number ``start``."""
    out = [Accumulation(plan) for plan in made]
    for number, frame in enumerate(frames, start):
        for acc, pixels in zip(out, cut.of(frame), strict=True):
            acc.add(pixels, number)
    return out


@contextmanager
def cluster(scheduler: str) -> Iterator[Any]:
    """A client of the scheduler at this address, or of one of this machine for "local".

    Raises
    ------
    InputError
        Dask is not installed, or no scheduler answers.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise InputError(
            f"--scheduler {scheduler}: needs Dask; pip install 'dask[distributed]'"
        ) from error
    if scheduler == "local":
        with (
            LocalCluster(threads_per_worker=1, dashboard_address=None) as made,
            Client(made) as client,
        ):
            yield client
        return
    try:
        client = Client(scheduler, timeout=TIMEOUT)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"--scheduler {scheduler}: no Dask scheduler answers there; give an address such as "
            "tcp://host:8786, or local"
        ) from error
    with client:
        yield client


class Runs:
    """One setting's frames, accumulated on a cluster.

    Parameters
    ----------
    client : distributed.Client
    frames : sequence of Frame
    cut : Cut
    saved : Path, optional
        Where what is merged so far is saved; removed at the end.
    run : int, optional
        Frames that a worker takes at a time.
    """

    def __init__(
        self,
        client: Any,
        frames: Sequence[Frame],
        cut: Cut,
        saved: Path | None = None,
        run: int | None = None,
    ) -> None:
        self.client, self.frames, self.cut, self.saved = client, frames, cut, saved
        self.workers = max(1, sum(client.nthreads().values()))
        self.run = run or max(1, min(RUN, -(-len(frames) // (2 * self.workers))))
        self.total: list[Accumulation] | None = None
        self._time = time.monotonic()

    @property
    def done(self) -> int:
        """Frames that are merged."""
        return self.total[0].frames if self.total else 0

    def merged(self) -> Iterator[int]:
        """Accumulate; yields the number of frames that are merged, until it is all of them."""
        self.total = saved_accumulation.load(self.saved) if self.saved else None
        if self.done:
            yield self.done
        try:
            for part in self._parts():
                self._merge(part)
                if time.monotonic() - self._time > SAVED_EVERY:
                    self.save()
                yield self.done
        finally:  # interrupted, or complete while other settings may still be interrupted
            self.save()

    def _parts(self) -> Iterator[list[Accumulation]]:
        if self.done == len(self.frames):
            return
        if self.total:
            made = [acc.plan for acc in self.total]
        else:
            made = self.client.submit(plans, self.frames[:2], self.cut, pure=False).result()
        starts = deque(range(self.done, len(self.frames), self.run))
        begun: deque[Any] = deque()
        while starts or begun:
            while starts and len(begun) < AHEAD * self.workers:
                start = starts.popleft()
                frames = self.frames[start : start + self.run]
                begun.append(
                    self.client.submit(accumulated, frames, self.cut, made, start, pure=False)
                )
            yield begun.popleft().result()

    def _merge(self, part: list[Accumulation]) -> None:
        if self.total is None:
            self.total = part
            return
        for acc, later in zip(self.total, part, strict=True):
            acc.merge(later)

    def save(self) -> None:
        """Keep what is merged so far, where that is wanted and possible."""
        if self.saved is None or self.total is None:
            return
        with suppress(OSError):
            saved_accumulation.save(self.saved, self.total)
        self._time = time.monotonic()
