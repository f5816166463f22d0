"""Processes that work beside this one.

Many of the statistics are small sums, of which two threads of one process seldom take two at a
time. A helper keeps the fields of its own parts from one simulation to the next, and only models
and statistics travel.
"""

from __future__ import annotations

import multiprocessing
import signal
import warnings
import weakref
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.fitting.simulated import THREADS, Job, Part, room, shared
from dnanalyze.loaders.captures import OperatingPoint, Sensor, Window
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in
from dnanalyze.processors import cpu_count

MOST = 7  # helpers
PATIENCE_S = 5.0  # with a helper at the end
WARM = 64, 64  # pixels of what a helper simulates before it is asked
# Pixels of a simulation from which a helper is worth its start. With one, `compare` is 0.2 s slower
# at 37,000 pixels and 2 s faster at 2 million.
WORTH = 500_000


Found = TypeVar("Found")


@dataclass(frozen=True)
class _Share:
    """Some parts of each of several jobs, with fields of theirs kept or not."""

    jobs: Sequence[Job]
    parts: Sequence[Sequence[Part]]
    kept: bool

    def __call__(self, memo: Memo) -> list[dict[Part, list[SettingStatistics]]]:
        return _taken(self.jobs, self.parts, memo if self.kept else Memo(0))


@dataclass(frozen=True)
class _Calls:
    """Calls of a function with several arguments."""

    function: Callable[..., Any]
    arguments: Sequence[tuple[Any, ...]]

    def __call__(self, memo: Memo) -> list[Any]:
        return [self.function(*a) for a in self.arguments]


_Task = _Share | _Calls


class Helpers:
    """Processes that take their share of the work; they end with this object.

    Parameters
    ----------
    count : int
        None by default: then threads of this process take the parts.
    """

    def __init__(self, count: int = 0) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipes: list[Connection] = []
        self.workers: list[SpawnProcess] = []
        for _ in range(count):
            mine, theirs = context.Pipe()
            worker = context.Process(target=_serve, args=(theirs, count + 1), daemon=True)
            worker.start()
            theirs.close()
            self._pipes.append(mine)
            self.workers.append(worker)
        self.close = weakref.finalize(self, _close, self._pipes, self.workers)

    @property
    def count(self) -> int:
        """Number of helpers that still work."""
        return len(self._pipes)

    def statistics(
        self, jobs: Sequence[Job], memo: Memo
    ) -> list[dict[Part, list[SettingStatistics]]]:
        """All parts of some jobs; those of a helper that failed, or is no more, are taken here."""
        away = [self.count > 0 and travels(job.model) for job in jobs]
        dealt = iter(self._dealt([j for j, goes in zip(jobs, away, strict=True) if goes], memo))
        return [
            next(dealt) if goes else _taken([job], [job.parts()], memo, THREADS)[0]
            for job, goes in zip(jobs, away, strict=True)
        ]

    def each(
        self, function: Callable[..., Found], arguments: Sequence[tuple[Any, ...]]
    ) -> list[Found]:
        """A function of each tuple of arguments, in turn by this process and the helpers.

        ``function``, its arguments and what it returns must be known to another process.
        """
        step = self.count + 1
        own, *others = [_Calls(function, arguments[n::step]) for n in range(step)]
        mine, *theirs = self._together(own, others, Memo(0))
        found: list[Any] = [None] * len(arguments)
        for n, share in enumerate((mine, *theirs)):
            found[n::step] = share
        return found

    def _dealt(self, jobs: Sequence[Job], memo: Memo) -> list[dict[Part, list[SettingStatistics]]]:
        """Jobs of which every process has its share."""
        if not jobs:
            return []
        *others, own = (
            _Share(jobs, parts, memo.limit_bytes > 0) for parts in shared(jobs, self.count + 1)
        )
        found, *more = self._together(own, others, memo)
        for share in more:
            for all_of_it, some in zip(found, share, strict=True):
                all_of_it |= some
        return list(found)

    def _together(self, own: _Task, others: Sequence[_Task], memo: Memo) -> list[Any]:
        """What this process finds and what each helper does, whose share is taken here if need be.

        Raises
        ------
        Exception
            What a task here raises.
        """
        for pipe, task in zip(self._pipes, others, strict=True):
            with suppress(OSError):
                pipe.send(task)
        try:
            mine = own(memo)
        finally:  # what is not taken now would be taken for the next tasks'
            answers = [self._answer(pipe) for pipe in list(self._pipes)]
        return [mine, *(t(memo) if a is None else a for a, t in zip(answers, others, strict=True))]

    def _answer(self, pipe: Connection) -> Any:
        """What a helper found; None where it failed, and no more of it where it is no more."""
        try:
            return pipe.recv()
        except (OSError, EOFError):
            pipe.close()
            self._pipes.remove(pipe)
            return None


def helpers_for(pixels: int) -> Helpers:
    """One for each further processor, where simulations of so many pixels are worth its start."""
    return Helpers(min(cpu_count() - 1, MOST) if pixels >= WORTH else 0)


def _taken(
    jobs: Sequence[Job], share: Sequence[Sequence[Part]], memo: Memo, threads: int = 1
) -> list[dict[Part, list[SettingStatistics]]]:
    """Some parts of each job."""
    return [
        dict(zip(parts, job.statistics(parts, memo, threads), strict=True))
        for job, parts in zip(jobs, share, strict=True)
    ]


def travels(model: NoiseModel) -> bool:
    """Whether another process knows all of its effects; one from a user's file it does not."""
    known = built_in()
    return all(known.get(effect.name) is type(effect) for effect in model.effects)


def _serve(pipe: Connection, shares: int) -> None:
    """What a helper does until the other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whom it helps decides
    warnings.simplefilter("ignore")  # the process that asked simulates the same model, and tells
    threadpool_limits(1)  # the other processors have helpers of their own
    memo = room(shares)
    with suppress(Exception):  # an effect of another package may fail; when asked for, it is told
        warm()
    with suppress(EOFError, OSError):
        while True:
            task = pipe.recv()
            try:
                found = task(memo)
            except Exception:  # met again, and told, by the process that asked
                found = None
            pipe.send(found)


def warm() -> None:
    """All that is imported and compiled when first used is, while the captures are being read."""
    model = NoiseModel(tuple(effect() for effect in built_in().values()))
    rows, columns = WARM
    halves = Window(0, rows // 2, 0, columns), Window(rows // 2, rows, 0, columns)
    job = Job(model, Sensor(WARM), halves, [(OperatingPoint(60.0, 0.1), 2)])
    job.statistics(job.parts(), Memo(0))


def _close(pipes: list[Connection], workers: list[SpawnProcess]) -> None:
    """The other ends see it, and end once their share is done."""
    for pipe in pipes:
        pipe.close()
    for worker in workers:
        worker.join(PATIENCE_S)
        worker.kill()
