"""Errors of a session's models: at once by the yardstick at hand, and then by their own.

Simulations for them end where a slider moves on: they take the processors from its previews.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace
from threading import Event, RLock, Thread
from typing import Any

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.processes import Helpers, travels
from dnanalyze.fitting.simulated import Job, Part
from dnanalyze.fitting.yardstick import REPLICATES
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effect import Effect
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.workbench.evaluation import Evaluation, exact, judged
from dnanalyze.workbench.heap import give_back

KEPT = 4  # evaluations held, some 10 MB each at 5 operating points of 512 x 512
GONE_S = 5.0  # without a move and without word of its rest: the page with the slider is closed
LOOK_S = 0.05  # between two looks whether it does
CALIBRATED = {"dpc"}  # effects that look at frames of another temperature


class Superseded(Exception):
    """What was simulated is no longer asked for."""


class Interruptible(Helpers):
    """Threads that end a simulation at the next frame when it is no longer asked for.

    Of the simulation of one half, operating points that a model shares with the one before are not
    simulated again: a slider mostly moves a number of one of them.

    Parameters
    ----------
    over : callable
        Whether that is so.
    """

    def __init__(self, over: Callable[[], bool]) -> None:
        super().__init__()
        self._over = over
        self._last: dict[Hashable, list[SettingStatistics]] = {}

    def statistics(
        self, jobs: Sequence[Job], memo: Memo
    ) -> list[dict[Part, list[SettingStatistics]]]:
        """All parts of some jobs.

        Raises
        ------
        Superseded
            They are no longer asked for.
        """
        return [self._parts(job, memo) for job in jobs]

    def _parts(self, job: Job, memo: Memo) -> dict[Part, list[SettingStatistics]]:
        parts = job.parts()
        keys = {part: _key(job, part) for part in parts}
        known = {} if job.half is None else self._last
        left = [part for part in parts if keys[part] not in known]

        def one(part: Part) -> list[SettingStatistics]:
            self._look()
            return job.statistics([part], memo, progress=self._look)[0]

        with ThreadPoolExecutor(job.threads) as pool:
            made = dict(zip(left, pool.map(one, left), strict=True))
        found = {part: made[part] if part in made else known[keys[part]] for part in parts}
        if job.half is not None:
            self._last = {keys[part]: seen for part, seen in found.items()}
        return found

    def _look(self, *_: Any) -> None:
        if self._over():
            raise Superseded


def _key(job: Job, part: Part) -> Hashable:
    """What the statistics of a part depend on."""
    point, frames = job.settings[part[0]]
    return seen_at(job.model, point), point, frames, part[1], job.half, job.even, job.errors


def seen_at(model: NoiseModel, point: OperatingPoint) -> Hashable:
    """What the frames of an operating point depend on: not on other entries of a table.

    A calibration, or an effect of the user's, may ask for other operating points.
    """
    if CALIBRATED & set(model.names) or not travels(model):
        return model
    there = point, model.reference_of(point.channel)

    def local(law: Any) -> Any:
        return tuple(law.at(p) for p in there) if isinstance(law, TableLaw) else law

    effects = tuple((type(e), *map(local, _numbers(e))) for e in model.effects)
    return local(model.pedestal), effects, replace(model, effects=(), pedestal=0.0)


def _numbers(effect: Effect) -> list[Any]:
    return [getattr(effect, f.name) for f in fields(effect)]


class Measurements:
    """Evaluations of models, the last few kept.

    Parameters
    ----------
    told : callable
        Called with an evaluation that has become exact, in a thread of its own.
    failed : callable
        Called with what a simulation raised, in that thread.
    busy : callable
        Whether the present model will soon be another one: its yardstick can wait.
    """

    def __init__(
        self,
        told: Callable[[Evaluation], None],
        failed: Callable[[Exception], None],
        busy: Callable[[], bool],
    ) -> None:
        self._told, self._failed, self._busy = told, failed, busy
        self._lock = RLock()
        self._kept: list[Evaluation] = []
        self._bench: FitProblem | None = None
        self._yardstick: FitProblem | None = None
        self._wanted: Evaluation | None = None
        self._working = False
        self._judging = False
        self._asked: NoiseModel | None = None
        self._failing: list[NoiseModel] = []  # whose yardstick raises
        self._moved_s = -math.inf
        self._closed = Event()

    def begin(self, problem: FitProblem) -> None:
        """Set the captures' statistics, with the standard errors that they state themselves."""
        self._bench = self._yardstick = replace(problem, helpers=Interruptible(self._given_up))

    def _given_up(self) -> bool:
        return self._closed.is_set() or self.moving

    @property
    def moving(self) -> bool:
        """Whether a slider moves: whatever else takes long waits for its rest."""
        return time.monotonic() - self._moved_s < GONE_S

    def close(self) -> None:
        """Compute no more yardsticks."""
        self._closed.set()

    def moved(self) -> None:
        """A slider moves: what is simulated for errors ends, and begins again when it rests."""
        self._moved_s = time.monotonic()

    def rested(self) -> None:
        """The slider rests."""
        self._moved_s = -math.inf

    def rest(self) -> bool:
        """Wait until no slider moves; False where no error is asked for."""
        while self.moving:
            if self._closed.wait(LOOK_S):
                return False
        return not self._closed.is_set()

    def now(self, model: NoiseModel, made: list[Statistics] | None = None) -> Evaluation:
        """A model's evaluation: exact where it is known, or else by the last model's yardstick.

        ``made``: the statistics of both simulated halves, where they are known.

        Raises
        ------
        Superseded
            A slider moved meanwhile.
        """
        found = self.kept(model)
        assert self._yardstick is not None
        if found is None:
            self._judging = True  # yardsticks wait: they take the same processors
            try:
                found = judged(self._yardstick, model, made)
            finally:
                self._judging = False
        self._keep(found)
        return found

    def refine(self, known: Evaluation) -> None:
        """Make an evaluation exact in the background, before earlier ones that are not."""
        with self._lock:
            self._asked = known.model
            self._wanted = self._earlier() if known.exact else known
            if self._working or self._wanted is None or self._closed.is_set():
                return
            self._working = True
        Thread(target=self._go_on, daemon=True).start()

    def _earlier(self) -> Evaluation | None:
        """A model that is not exact yet: its error is compared with the present one's."""
        left = (e for e in self._kept if not e.exact and e.model not in self._failing)
        return next(left, None)

    def kept(self, model: NoiseModel) -> Evaluation | None:
        """The evaluation of a model, where it is still held."""
        with self._lock:
            return next((e for e in self._kept if e.model == model), None)

    def _keep(self, found: Evaluation) -> None:
        with self._lock:
            others = (e for e in self._kept if e.model != found.model)
            self._kept = [found, *others][:KEPT]

    def _go_on(self) -> None:
        while True:
            with self._lock:
                wanted = self._wanted
                if wanted is None or self._closed.is_set():
                    self._working = False
                    give_back()
                    return
            try:
                found = self._refined(wanted)
            except Superseded:
                continue
            except Exception as error:  # an effect of the user's may raise anything
                self._failing = [*self._failing, wanted.model][-KEPT:]
                self._drop(wanted)
                self._failed(error)
                continue
            if found is not None:
                self._keep(found)
                if found.model == self._asked:
                    self._yardstick = found.problem
                self._drop(wanted)
                self._told(found)

    def _drop(self, done: Evaluation) -> None:
        with self._lock:
            if self._wanted is done:
                self._wanted = self._earlier()

    def _refined(self, known: Evaluation) -> Evaluation | None:
        """An evaluation by its own yardstick; None where another is wanted before it is done.

        The problem keeps each simulated sensor: what was begun is not begun anew.
        """
        assert self._bench is not None
        for number in range(REPLICATES):
            if not self.rest():
                return None
            while self._busy() or self._judging:
                if self._closed.wait(LOOK_S):
                    return None
            if self._wanted is not known:
                return None
            self._bench.replicate(known.model, number)
        return exact(self._bench, known)
