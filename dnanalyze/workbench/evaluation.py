"""The error of a model: exact, by a yardstick at hand, and as a preview.

The exact error is that of `compare`: what a second sensor of the same design differs by is
simulated from the model itself. Simulating the frames alone and judging them by the yardstick of
another model takes a ninth of the time. A preview simulates a small window of every operating point
and adds the change of each statistic, from a model whose full error is known, to that model's
differences. Both are drawn with the same random numbers, so that the change is that of the model
and scarcely that of the draw (common random numbers).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from dnanalyze.analyzers.analyze import NAMES, analyze_windows
from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.comparator.compare import rows_of
from dnanalyze.comparator.error import family_errors, pooled
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.vectors import places, prediction
from dnanalyze.fitting.yardstick import by_design
from dnanalyze.loaders.captures import Window
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulated_by
from dnanalyze.model.simulator import Simulator

SIDE = 128  # pixels of a preview's window; 3 frames of 5 operating points take about .09 s of CPU
FRAMES = 3  # of each operating point; 2 at least for temporal noise, 3 for its correlation
MEMORY = 64 << 20  # bytes of fields kept for previews
WHOLE_FIELD = "shading"  # family of which a window says nothing


@dataclass(frozen=True)
class Evaluation:
    """A model compared with the measurement on the held-out half of the field.

    Parameters
    ----------
    model : NoiseModel
    differences : ndarray
        (measured - simulated) / reproducibility standard deviation, in the order of the problem's
        held-out target.
    error : float
        Model error; 1.0 = as close as a second sensor of the same design.
    families : mapping
        Error of each family.
    simulated : Statistics
        Of the held-out half, with their curves; for a preview those of the known model.
    problem : FitProblem
        By the yardstick that the differences are stated in.
    predicted : ndarray
        Coordinates of the simulated statistics, in the same order; empty for a preview.
    rows : list of dict
        One row a statistic and operating point, as `compare` gives; empty for a preview.
    exact : bool
        Whether the yardstick is the model's own: then the error is that of `compare`.
    change : pair of Statistics, optional
        Of a preview's window before and after the change.
    """

    model: NoiseModel
    differences: np.ndarray
    error: float
    families: Mapping[str, float]
    simulated: Statistics
    problem: FitProblem
    predicted: np.ndarray = field(default_factory=lambda: np.zeros(0))
    rows: list[dict[str, Any]] = field(default_factory=list)
    exact: bool = False
    change: tuple[Statistics, Statistics] | None = None

    @property
    def preview(self) -> bool:
        """Whether it is an estimate from a window."""
        return self.change is not None


def evaluate(problem: FitProblem, model: NoiseModel) -> Evaluation:
    """The full comparison of a model, with the error that `compare` states."""
    return exact(problem, judged(problem, model))


def judged(
    problem: FitProblem, model: NoiseModel, made: list[Statistics] | None = None
) -> Evaluation:
    """The full comparison of a model by the yardstick of the problem, whatever model that is of.

    ``made``: the statistics of the simulated halves, where they are known; of the half that is
    fitted the shading alone is needed.
    """
    made = made or problem.statistics(model, half=1)
    return _stated(problem, model, made[1], prediction(made, 1, problem.test))


def exact(problem: FitProblem, known: Evaluation) -> Evaluation:
    """The same comparison by the yardstick of its own model."""
    own = by_design(problem, known.model)
    found = _stated(own, known.model, known.simulated, known.predicted)
    return replace(found, exact=True)


def error_by(problem: FitProblem, known: Evaluation) -> float:
    """The error of an evaluated model by the yardstick of another problem."""
    return pooled(problem.test.z(known.predicted), problem.test.families)


def _stated(
    problem: FitProblem, model: NoiseModel, simulated: Statistics, predicted: np.ndarray
) -> Evaluation:
    z, families = problem.test.z(predicted), problem.test.families
    errors = pooled(z, families), family_errors(z, families)
    return Evaluation(model, z, *errors, simulated, problem, predicted, rows_of(problem, predicted))


class Preview:
    """Quick evaluations of models near one whose full evaluation is known.

    Parameters
    ----------
    problem : FitProblem
    known : Evaluation
        Of the model from which changes are taken.
    side, frames : int
        Size of the window, pixels, and number of frames of each operating point.
    """

    def __init__(
        self, problem: FitProblem, known: Evaluation, side: int = SIDE, frames: int = FRAMES
    ) -> None:
        self.problem = problem
        self.known = known
        self.window = _centre(problem.plan.test, side)
        self.settings = [(point, min(n, frames)) for point, n in problem.plan.settings]
        self._memo = Memo(MEMORY, charge=Memo(MEMORY))
        self._window = self._statistics(known.model)
        self._before = self._coordinates(self._window)

    def evaluate(self, model: NoiseModel) -> Evaluation:
        """A preview of a model's error and of its curves."""
        made = self._statistics(model)
        target = self.known.problem.test
        change = (self._coordinates(made) - self._before) / target.reproducibility_sd
        z = self.known.differences - np.nan_to_num(change, nan=0.0, posinf=0.0, neginf=0.0)
        return Evaluation(
            model,
            z,
            pooled(z, target.families),
            family_errors(z, target.families),
            self.known.simulated,
            self.known.problem,
            change=(self._window, made),
        )

    def rebased(self, known: Evaluation) -> Preview:
        """The same window, with changes taken from another model."""
        other = object.__new__(Preview)
        other.__dict__.update(self.__dict__)
        other.known = known
        if known.model != self.known.model:
            other._window = other._statistics(known.model)
            other._before = other._coordinates(other._window)
        return other

    def _statistics(self, model: NoiseModel) -> Statistics:
        sensor = self.problem.plan.captures.sensor
        simulator = Simulator(model.in_codes, sensor.shape, self._memo)
        made = simulated_by(simulator, self.settings, "preview", sensor)
        told = [name for name in NAMES if name != WHOLE_FIELD]
        return analyze_windows(made, [self.window], workers=1, errors=False, families=told)[0]

    def _coordinates(self, made: Statistics) -> np.ndarray:
        """Statistics of the window on the target's scales; NaN for those it does not tell."""
        test = self.problem.test
        pairs = zip(places(made), made.settings, strict=True)
        found = test.coordinates_of({place: setting.values for place, setting in pairs})
        return np.where(test.families == WHOLE_FIELD, np.nan, found)


def _centre(window: Window, side: int) -> Window:
    """A square in the middle of a window, or what the window has of it, on even edges."""
    rows, columns = (min(side, n) // 2 * 2 for n in window.shape)
    top = window.top + (window.shape[0] - rows) // 4 * 2
    left = window.left + (window.shape[1] - columns) // 4 * 2
    return Window(top, top + rows, left, left + columns)
