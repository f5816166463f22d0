"""Executors that work beside this process, or for it.

Many of the statistics are small sums, of which two threads of one process seldom compute two at a
time. A worker keeps the fields of its own parts from one simulation to the next, and only models
and statistics travel.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import warnings
import weakref
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import suppress
from functools import cache, partial
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.executors import answer, submitted
from dnanalyze.fitting.design import MOST_SETTINGS
from dnanalyze.fitting.simulated import SHARED_FROM_PIXELS, Job, Part, room, shared
from dnanalyze.loaders.captures import OperatingPoint, Sensor, Window
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.processors import cpu_count

SHARES = 2 * MOST_SETTINGS  # of the work at most: the halves of all operating points
ROOMS = 4  # workers of such an executor that are expected on one machine
WARM = 64, 64  # pixels of what a worker simulates before it is asked

Found = TypeVar("Found")


_Task = Callable[[Memo], list[Any]]  # a share of the work; None where there is nothing to do


class Helpers:
    """Executors that take shares of the work; what they fail to do is done by this process.

    Parameters
    ----------
    executors : sequence of Executor
        One a share; each gets the same parts of every simulation. None by default: then threads of
        this process take the parts.
    here : bool
        Whether this process takes a share too.
    rooms : int
        Processes among which a machine's memory for fields is divided.
    """

    def __init__(
        self, executors: Iterable[Executor] = (), *, here: bool = True, rooms: int = 1
    ) -> None:
        self._executors = list(executors)
        self._here = here
        self._rooms = rooms

    @property
    def shares(self) -> int:
        """Number of shares into which work is divided."""
        return max(len(self._executors) + self._here, 1)

    def statistics(
        self, jobs: Sequence[Job], memo: Memo
    ) -> list[dict[Part, list[SettingStatistics]]]:
        """All parts of some jobs."""
        away = [bool(self._executors) and travels(job.model) for job in jobs]
        dealt = iter(self._dealt([j for j, goes in zip(jobs, away, strict=True) if goes], memo))
        return [
            next(dealt) if goes else _taken([job], [job.parts()], memo, job.threads)[0]
            for job, goes in zip(jobs, away, strict=True)
        ]

    def each(
        self, function: Callable[..., Found], arguments: Sequence[tuple[Any, ...]]
    ) -> list[Found]:
        """A function of each tuple of arguments, divided among the shares.

        ``function``, its arguments and what it returns must be known to another process.
        """
        step = self.shares
        shares = [arguments[n::step] for n in range(step)]
        tasks = [partial(_called, function, share) if share else None for share in shares]
        found: list[Any] = [None] * len(arguments)
        for n, share in enumerate(self._done(tasks, Memo(0))):
            found[n::step] = share
        return found

    def _dealt(self, jobs: Sequence[Job], memo: Memo) -> list[dict[Part, list[SettingStatistics]]]:
        """Jobs of which every executor has its share."""
        kept = memo.limit_bytes > 0
        tasks = [
            partial(_share, jobs, parts, kept) if any(parts) else None
            for parts in (shared(jobs, self.shares) if jobs else ())
        ]
        found: list[dict[Part, list[SettingStatistics]]] = [{} for _ in jobs]
        for share in self._done(tasks, memo):
            for all_of_it, some in zip(found, share, strict=False):
                all_of_it |= some
        return found

    def _done(self, tasks: Sequence[_Task | None], memo: Memo) -> list[Any]:
        """What each task finds: the first are those of the executors, the rest of this process.

        Raises
        ------
        Exception
            What a task here raises.
        """
        away = [
            self._submitted(executor, task)
            for executor, task in zip(list(self._executors), tasks, strict=False)
        ]
        here = [task(memo) if task else [] for task in tasks[len(away) :]]
        pairs = zip(away, tasks, strict=False)
        return [answer(future, task, memo) if task else [] for future, task in pairs] + here

    def _submitted(self, executor: Executor, task: _Task | None) -> Future[Any] | None:
        """The task given to an executor; None where there is nothing to do, or nobody to do it."""
        if task is None:
            return None
        future = submitted(executor, _at_worker, task, self._rooms)
        if future is None:
            self._executors = [e for e in self._executors if e is not executor]
        return future


class Processes(Helpers):
    """Processes of this object, which end with it; each is an executor of its own.

    Parameters
    ----------
    count : int
    """

    def __init__(self, count: int) -> None:
        context = multiprocessing.get_context("spawn")
        lifelines: list[Connection] = []
        executors = []
        for _ in range(count):
            theirs, mine = context.Pipe(duplex=False)
            executor = ProcessPoolExecutor(1, context, _begin, (theirs,))
            executor.submit(_warmed)
            theirs.close()
            lifelines.append(mine)
            executors.append(executor)
        super().__init__(executors, rooms=count + 1)
        self.close = weakref.finalize(self, _close, lifelines, executors)


def helpers_for(pixels: int) -> Processes:
    """One for each further processor, where simulations of so many pixels are worth its start."""
    return Processes(min(cpu_count(), SHARES) - 1 if pixels >= SHARED_FROM_PIXELS else 0)


def helpers_of(executor: Executor | None) -> Helpers:
    """Those of a caller's executor, such as of a Dask client; without one this process."""
    if executor is None:
        return Helpers()
    return Helpers([executor] * SHARES, here=False, rooms=ROOMS)


def _taken(
    jobs: Sequence[Job], share: Sequence[Sequence[Part]], memo: Memo, threads: int = 1
) -> list[dict[Part, list[SettingStatistics]]]:
    """Some parts of each job."""
    return [
        dict(zip(parts, job.statistics(parts, memo, threads), strict=True))
        for job, parts in zip(jobs, share, strict=True)
    ]


def _share(
    jobs: Sequence[Job], parts: Sequence[Sequence[Part]], kept: bool, memo: Memo
) -> list[dict[Part, list[SettingStatistics]]]:
    """Some parts of each job, with fields of theirs ``kept`` or not."""
    return _taken(jobs, parts, memo if kept else Memo(0))


def _called(
    function: Callable[..., Found], arguments: Sequence[tuple[Any, ...]], memo: Memo
) -> list[Found]:
    return [function(*a) for a in arguments]


def travels(model: NoiseModel) -> bool:
    """Whether another process knows all of its effects; one from a user's file it does not."""
    known = built_in()
    return all(known.get(effect.name) is type(effect) for effect in model.effects)


def _at_worker(task: _Task, rooms: int) -> Any:
    return task(_room(rooms))


@cache
def _room(rooms: int) -> Memo:
    """What a worker keeps between its tasks."""
    return room(rooms)


def _begin(lifeline: Connection) -> None:
    """What a process does first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that it works for decides
    warnings.simplefilter("ignore")  # the process that asked simulates the same model, and tells
    threadpool_limits(1)  # the other processors have workers of their own
    threading.Thread(target=_end_with, args=(lifeline,), daemon=True).start()


def _end_with(lifeline: Connection) -> None:
    """End this process when the other end is closed, or the process that held it is no more."""
    with suppress(EOFError, OSError):
        lifeline.recv()
    os._exit(0)


def _warmed() -> None:
    with suppress(Exception):  # an effect of another package may fail; when asked for, it is told
        warm()


def warm() -> None:
    """All that is imported and compiled when first used is, while the captures are being read."""
    model = NoiseModel(tuple(effect() for effect in built_in().values()))
    rows, columns = WARM
    halves = Window(0, rows // 2, 0, columns), Window(rows // 2, rows, 0, columns)
    job = Job(model, Sensor(WARM), halves, [(OperatingPoint(60.0, 0.1), 2)])
    job.statistics(job.parts(), Memo(0))


def _close(lifelines: Sequence[Connection], executors: Sequence[Executor]) -> None:
    for lifeline in lifelines:
        lifeline.close()
    for executor in executors:
        executor.shutdown(wait=False, cancel_futures=True)
