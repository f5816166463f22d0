"""Processes that simulate beside this one.

Many of the statistics are small sums, of which two threads of one process seldom take two at a
time. A helper keeps the fields of its own parts from one simulation to the next, and only models
and statistics travel.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import warnings
import weakref
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any

from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.fitting.simulated import THREADS, Job, Part, room, shared
from dnanalyze.loaders.captures import OperatingPoint, Sensor, Window
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in

MOST = 7  # helpers
PATIENCE_S = 5.0  # with a helper at the end
WARM = 64, 64  # pixels of what a helper simulates before it is asked
WORTH = 3_000_000  # pixels of a simulation from which a helper is worth its start


class Helpers:
    """Processes that take their share of simulations; they end with this object.

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

    def statistics(
        self, jobs: Sequence[Job], memo: Memo
    ) -> list[dict[Part, list[SettingStatistics]]]:
        """All parts of some jobs; those of a helper that failed, or is no more, are taken here."""
        away = [bool(self._pipes) and _travels(job.model) for job in jobs]
        dealt = iter(self._dealt([j for j, goes in zip(jobs, away, strict=True) if goes], memo))
        return [
            next(dealt) if goes else _taken([job], [job.parts()], memo, THREADS)[0]
            for job, goes in zip(jobs, away, strict=True)
        ]

    def _dealt(self, jobs: Sequence[Job], memo: Memo) -> list[dict[Part, list[SettingStatistics]]]:
        """Jobs of which every process has its share."""
        if not jobs:
            return []
        *shares, own = shared(jobs, len(self._pipes) + 1)
        for pipe, share in zip(self._pipes, shares, strict=True):
            with suppress(OSError):
                pipe.send((jobs, share, memo.limit_bytes > 0))
        try:
            found = _taken(jobs, own, memo)
        finally:  # what is not taken now would be taken for the next jobs'
            answers = [self._answer(pipe) for pipe in list(self._pipes)]
        for answer, share in zip(answers, shares, strict=True):
            taken = _taken(jobs, share, memo) if answer is None else answer
            for all_of_it, more in zip(found, taken, strict=True):
                all_of_it |= more
        return found

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
    return Helpers(min(len(os.sched_getaffinity(0)) - 1, MOST) if pixels >= WORTH else 0)


def _taken(
    jobs: Sequence[Job], share: Sequence[Sequence[Part]], memo: Memo, threads: int = 1
) -> list[dict[Part, list[SettingStatistics]]]:
    """Some parts of each job."""
    return [
        dict(zip(parts, job.statistics(parts, memo, threads), strict=True))
        for job, parts in zip(jobs, share, strict=True)
    ]


def _travels(model: NoiseModel) -> bool:
    """Whether another process knows all of its effects; one from a user's file it does not."""
    known = built_in()
    return all(known.get(effect.name) is type(effect) for effect in model.effects)


def _serve(pipe: Connection, shares: int) -> None:
    """What a helper does until the other end is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whom it helps decides
    warnings.simplefilter("ignore")  # the process that asked simulates the same model, and tells
    memo = room(shares)
    with suppress(Exception):  # an effect of another package may fail; when asked for, it is told
        _warm()
    with suppress(EOFError, OSError):
        while True:
            jobs, share, kept = pipe.recv()
            try:
                found = _taken(jobs, share, memo if kept else Memo(0))
            except Exception:  # met again, and told, by the process that asked
                found = None
            pipe.send(found)


def _warm() -> None:
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
