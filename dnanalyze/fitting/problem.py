"""The fit problem: measured statistics, and the statistics that a model predicts."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.fitting.design import Design, design
from dnanalyze.fitting.free_parameters import FreeParameter
from dnanalyze.fitting.level import Level, allowed, dark_signals, level
from dnanalyze.fitting.processes import Helpers, helpers_of
from dnanalyze.fitting.simulated import Job, room
from dnanalyze.fitting.ties import Direct, Tie, direct
from dnanalyze.fitting.time_limit import TimeLimit
from dnanalyze.fitting.vectors import Target, prediction, target
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.effect import Placing
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel

PREDICTIONS_BYTES = 16 << 20  # some hundred simulations, 10 kB each at 10 operating points


@dataclass(frozen=True)
class FitProblem:
    """Measured statistics, and the simulation of captures of the same layout.

    Parameters
    ----------
    plan : Design
        What is looked at.
    measured : list of Statistics
        Of the train and the test half.
    train, test : Target
    memo : Memo
        Fields kept between simulations.
    predictions : Memo
        What was simulated is not simulated again: a fit begins on a part of the field, and so does
        the next search.
    helpers : Helpers
        Processes that share them; none by default.
    part : FitProblem, optional
        The same of a part of the field, where a fit may begin.
    even : bool
        Whether only models are simulated that hold all over the field by the same law: the half
        that is not wanted then need not be.
    direct : Direct
        What all operating points tell directly of the parameters.
    limit : TimeLimit
        Of the simulations that fits ask for.
    """

    plan: Design
    measured: list[Statistics]
    train: Target
    test: Target
    memo: Memo = field(default_factory=room)
    predictions: Memo = field(default_factory=partial(Memo, PREDICTIONS_BYTES))
    helpers: Helpers = field(default_factory=Helpers)
    part: FitProblem | None = None
    even: bool = False
    direct: Direct = field(default_factory=Direct)
    limit: TimeLimit = field(default_factory=TimeLimit)

    def within(self, limit: TimeLimit) -> FitProblem:
        """This problem with a limit of time, and its part alike."""
        part = None if self.part is None else self.part.within(limit)
        return replace(self, limit=limit, part=part)

    def with_memo(self, memo: Memo) -> FitProblem:
        """This problem with other room for fields, which its part shares."""
        part = None if self.part is None else self.part.with_memo(memo)
        return replace(self, memo=memo, part=part)

    def scaled(self, train: np.ndarray, test: np.ndarray) -> FitProblem:
        """This problem by another yardstick: factors of the stated errors of either half."""
        return replace(self, train=self.train.scaled(train), test=self.test.scaled(test))

    def scaled_as(self, other: FitProblem) -> FitProblem:
        """This problem by the yardstick of another one, such as a part of the field."""
        pairs = zip((self.train, self.test), (other.train, other.test), strict=True)
        return self.scaled(*(h.scale_of(o) for h, o in pairs)).weighted(other.train.misfit)

    def weighted(self, misfit: float) -> FitProblem:
        """This problem with the weights of a loss of which a share is misfit, see `Target`."""
        train, test = (replace(half, misfit=misfit) for half in (self.train, self.test))
        return replace(self, train=train, test=test)

    def evened(self, model: NoiseModel) -> FitProblem:
        """This problem, without the half that is not wanted where the model lets it be left out.

        What lies anywhere shades the two halves by chance alone, but otherwise than one of them and
        its mirror image.
        """
        return replace(self, even=self.even or model.placing < Placing.SOMEWHERE)

    def statistics(
        self, model: NoiseModel, errors: bool = False, half: int | None = None
    ) -> list[Statistics]:
        """Statistics of both halves of a simulated capture set.

        ``half``: the one that is wanted, with the shading of the other; both by default.
        """
        return self._simulated([self._job(model, half, errors)])[0]

    def _job(self, model: NoiseModel, half: int | None, errors: bool = False) -> Job:
        plan = self.plan
        sensor = plan.captures.sensor
        return Job(model, sensor, plan.windows, plan.settings, errors, half, self.even)

    def _simulated(self, jobs: Sequence[Job]) -> list[list[Statistics]]:
        made = self.helpers.statistics(jobs, self.memo)
        return [job.together(found) for job, found in zip(jobs, made, strict=True)]

    def coordinates(self, model: NoiseModel) -> tuple[np.ndarray, np.ndarray]:
        """Predicted coordinates of (train, test)."""
        made = self.statistics(model)
        return prediction(made, 0, self.train), prediction(made, 1, self.test)

    def several(self, models: Sequence[NoiseModel]) -> list[np.ndarray]:
        """`fitted_coordinates` of several models, which the processes share as one.

        Raises
        ------
        TimeUp
            The time is up.
        """
        found: dict[NoiseModel, Any] = {m: self.predictions.find(self._key(m)) for m in models}
        wanted = [m for m, known in found.items() if known is None]
        count = self.limit.batch or max(1, len(wanted))
        for begin in range(0, len(wanted), count):
            self.limit.check()
            batch = wanted[begin : begin + count]
            made = self._simulated([self._job(model, half=0) for model in batch])
            for model, seen in zip(batch, made, strict=True):
                found[model] = prediction(seen, 0, self.train)
                self.predictions.get(self._key(model), partial(found.get, model))
        return [found[m] for m in models]

    def _key(self, model: NoiseModel) -> Hashable:
        """Key under which a prediction of the fitted half is cached."""
        return (model, self.even, self.plan.windows, *self.plan.settings)

    def fitted_coordinates(self, model: NoiseModel) -> np.ndarray:
        """Predicted coordinates of the fitted half."""
        return self.several([model])[0]

    def fitted_z(self, model: NoiseModel) -> np.ndarray:
        """Misfits z of the fitted half."""
        return self.train.z(self.fitted_coordinates(model))

    def held_out_z(self, model: NoiseModel) -> np.ndarray:
        """Misfits z of the held-out half."""
        return self.test.z(prediction(self.statistics(model, half=1), 1, self.test))

    def level(self, train: np.ndarray, test: np.ndarray) -> Level | None:
        """The dark level of a model, from its misfits z on both halves."""
        points = [point for point, _ in self.plan.settings]
        signals = dark_signals(self.measured[0], self.train, self.direct.black)
        return level(points, (self.train, self.test), (train, test), signals)

    def ties(
        self, model: NoiseModel, free: Sequence[FreeParameter], overdispersion: float
    ) -> tuple[Tie, ...]:
        """Constraints of the free parameters of a model by direct measurements."""
        return self.direct.ties(model, free, self.plan.shape, overdispersion)

    def only(self, settings: list[int]) -> FitProblem:
        """The same problem with some of its settings."""
        chosen = tuple(self.plan.captures.settings[i] for i in settings)
        members = tuple(self.plan.members[i] for i in settings)
        captures = replace(self.plan.captures, settings=chosen)
        plan = replace(self.plan, captures=captures, members=members)
        return replace(
            self,
            plan=plan,
            train=self.train.only(settings),
            test=self.test.only(settings),
            part=None if self.part is None else self.part.only(settings),
        )

    def replicate(self, model: NoiseModel, number: int) -> tuple[np.ndarray, np.ndarray]:
        """Predicted coordinates of another sensor of the same design.

        Raises
        ------
        TimeUp
            The time is up.
        """
        other = replace(model, seed=model.seed + 1 + number)
        # Its fields are drawn once, and would only push the useful ones out of the memo.
        problem = self.with_memo(Memo(0))

        def drawn() -> tuple[np.ndarray, np.ndarray]:
            self.limit.check()
            return problem.coordinates(other)

        return self.predictions.get(("both halves", self._key(other)), drawn)


def _of_all(plan: Design, measured: Statistics) -> Statistics:
    """Level and noise of the fitted half at all operating points, also those left out."""
    if len(plan.everything.settings) == len(plan.captures.settings):
        return measured
    return analyze_windows(plan.everything, [plan.train], families=("level", "time", "neighbours"))[
        0
    ]


def fit_problem(plan: Design, helpers: Helpers | None = None) -> FitProblem:
    """Read the captures once and take the statistics of both halves."""
    plans = [plan] if plan.part is None else [plan, plan.part]
    measured = analyze_windows(plan.captures, [w for p in plans for w in p.windows])
    memo, helpers, predictions = room(), helpers or Helpers(), Memo(PREDICTIONS_BYTES)
    known = direct(_of_all(plan, measured[0]))

    def of(number: int, part: FitProblem | None = None) -> FitProblem:
        halves = measured[2 * number : 2 * number + 2]
        train, test = target(halves, 0), target(halves, 1)
        signals = dark_signals(halves[0], train, known.black)
        points = [point for point, _ in plans[number].settings]
        train = replace(train, allowed=allowed(train, signals, points, known.black))
        return FitProblem(
            plans[number], halves, train, test, memo, predictions, helpers, part, number > 0, known
        )

    return of(0, of(1) if plan.part else None)


def problem_of(
    captures: CaptureSet, model: NoiseModel | None = None, executor: Executor | None = None
) -> FitProblem:
    """`fit_problem` of captures, in the unit of a model.

    ``executor``: what takes the simulations; without one this process.
    """
    plan = design(captures, unit=None if model is None else model.unit)
    return fit_problem(plan, helpers_of(executor))
