"""Compare a model with measured captures: discrepancies, model error, largest misfits."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.comparator.error import family_errors, pooled
from dnanalyze.comparator.predictive_check import FittedModel
from dnanalyze.comparator.words import failures
from dnanalyze.digits import number
from dnanalyze.fitting.fit import as_captured, at_a_glance, fit_on, with_seed
from dnanalyze.fitting.level import Level
from dnanalyze.fitting.problem import FitProblem, problem_of
from dnanalyze.fitting.start import gaussian_model
from dnanalyze.fitting.state import State
from dnanalyze.fitting.vectors import prediction
from dnanalyze.fitting.whole_field import Coverage, coverage
from dnanalyze.fitting.yardstick import by_design
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE
from dnanalyze.progress import Progress, ignored, reporter
from dnanalyze.result import Result


@dataclass(frozen=True, repr=False)
class Comparison(Result):
    """A model compared with a measurement, on the held-out half of the field.

    Parameters
    ----------
    captures : CaptureSet
        The measured frames.
    model : NoiseModel
        The model that was compared.
    error : float
        1 = as close as a second sensor of the same design.
    baselines : dict
        "gaussian" and "paper": the errors of the Gaussian baseline and of the Wang 2025 model.
    families : dict
        Error of each family.
    statistics : list of dict
        One row for each statistic and operating point.
    failures : list of str
        Where the model fails, worst first.
    unexplained : list of str
        Statistics that differ by more than simulated sensors of the model do, worst first; empty
        where the model is adequate, as in `diagnose`.
    measured, simulated, gaussian : Statistics
        Of the held-out half, with their curves.
    level : Level, optional
        Difference between the mean dark signals of model and captures.
    coverage : Coverage, optional
        What of the captures it rests on, and where the model departs from the rest of the field.
    """

    captures: CaptureSet = field(compare=False)
    model: NoiseModel
    error: float
    baselines: dict[str, float]
    families: dict[str, float]
    statistics: list[dict[str, Any]]
    failures: list[str]
    unexplained: list[str]
    measured: Statistics
    simulated: Statistics
    gaussian: Statistics
    level: Level | None = None
    coverage: Coverage | None = None

    @property
    def adequate(self) -> bool:
        """Whether error and statistics are those of a second sensor of the same design."""
        return not self.unexplained

    def _brief(self) -> str:
        return f"{self.captures.name}, model error {number(self.error)}"


def compare(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    seed: int | None = None,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Comparison:
    """Compare a model with dark frames.

    Parameters
    ----------
    captures : CaptureSet
        Dark frames.
    model : NoiseModel, optional
        Taken as it is. Without one the Wang 2025 model is fitted first.
    seed : int, optional
        Seed of the simulated sensor; by default the model's.
    progress : callable, optional
        Called with (steps done, None, what is under way); see `dnanalyze.progress.Progress`.
    executor : concurrent.futures.Executor, optional
        Takes the simulations that do not depend on each other: processes, or those of a Dask client
        (``client.get_executor()``). By default threads of this process. Results are the same to the
        last bit.

    Returns
    -------
    Comparison
        The model error, 1 for a model as close as a second sensor of the same design, and the
        statistics behind it, measured and simulated.

    Raises
    ------
    InputError
        Captures too small to halve, or of a channel that the model does not know.

    Examples
    --------
    >>> import dnanalyze
    >>> from dnanalyze.demo import tiny
    >>> captures = tiny()
    >>> comparison = dnanalyze.compare(captures)
    >>> comparison.error > 1.0
    True
    >>> sorted(comparison.baselines)
    ['gaussian', 'paper']
    """
    return compare_on(captures, model, seed=seed, on_state=reporter(progress), executor=executor)


def compare_on(
    captures: CaptureSet,
    model: NoiseModel | None = None,
    *,
    seed: int | None = None,
    problem: FitProblem | None = None,
    executor: Executor | None = None,
    on_state: Callable[[State], None] = ignored,
) -> Comparison:
    """`compare` with statistics taken earlier.

    ``on_state`` is called with every better state of the fit of the Wang 2025 model.
    """
    problem = problem or problem_of(captures, model, executor)
    begun = None if model is not None else with_seed(problem, None, seed)
    model = None if model is None else with_seed(problem, model, seed)
    paper = fit_on(captures, begun, problem=problem, replicates=0, on_state=on_state).model
    model = model or paper
    return compared(captures, by_design(problem, model), model, paper)


def compared(
    captures: CaptureSet, problem: FitProblem, model: NoiseModel, paper: NoiseModel | None
) -> Comparison:
    """`compare` by the yardstick of ``problem``.

    ``paper``: the fitted Wang 2025 model; None where it is not known.
    """
    plain = problem.statistics(as_captured(problem, gaussian_model(at_a_glance(problem))), True)
    made = problem.statistics(model, errors=True)
    train, z = (
        half.z(prediction(made, n, half)) for n, half in enumerate((problem.train, problem.test))
    )
    baselines = {"gaussian": error_of(problem, plain)}
    if paper is not None:
        same = paper == model
        baselines["paper"] = error_of(problem, made if same else problem.statistics(paper))
    rows = table(problem, made)
    state = State(model, [], train, lambda: z, np.empty((len(train), 0)))
    return Comparison(
        captures,
        model,
        pooled(z, problem.test.families),
        baselines,
        family_errors(z, problem.test.families),
        rows,
        failures(rows),
        FittedModel(problem, state).unexplained,
        problem.measured[1],
        made[1],
        plain[1],
        problem.level(train, z),
        coverage(problem.plan, model),
    )


def paper_model(
    problem: FitProblem, begun: NoiseModel | None, in_time: bool = True
) -> NoiseModel | None:
    """The fitted Wang 2025 model: ``begun``, with which a search began, if that is one.

    Else it is fitted; None where the time is up.
    """
    if begun is not None and set(begun.names) <= {BASE, "quantization"}:
        return begun
    captures = problem.plan.captures
    return fit_on(captures, replicates=0, problem=problem).model if in_time else None


def error_of(problem: FitProblem, made: list[Statistics]) -> float:
    """Error of simulated statistics on the held-out half."""
    return pooled(problem.test.z(prediction(made, 1, problem.test)), problem.test.families)


def table(problem: FitProblem, made: list[Statistics]) -> list[dict[str, Any]]:
    """One row per statistic: measured, simulated, reproducibility SD (key floor), discrepancy."""
    return rows_of(problem, prediction(made, 1, problem.test))


def rows_of(problem: FitProblem, simulated: np.ndarray) -> list[dict[str, Any]]:
    """The rows of `table` from the coordinates predicted for the held-out half."""
    known = infos()
    target = problem.test
    z = target.z(simulated)
    rows = []
    for i, key in enumerate(target.keys):
        point = problem.plan.settings[key.setting][0]
        info = known[key.name]
        value = info.scale.plain(float(simulated[i]))
        rows.append(
            {
                "name": key.name,
                "family": info.family,
                **vars(point),  # temperature_c, exposure_s, gain, channel
                "plane": key.plane,
                "unit": info.unit,
                "scale": str(info.scale),
                "measured": float(target.values[i]),
                "simulated": value,
                "floor": float(target.reproducibility_sd[i]),
                "discrepancy": float(z[i]),
                "relative": _relative(float(target.values[i]), value),
            }
        )
    return rows


def _relative(measured: float, simulated: float) -> float | None:
    """(measured - simulated) / |simulated|; None where that has no meaning."""
    if not np.isfinite(simulated) or abs(simulated) < 1e-12:
        return None
    return (measured - simulated) / abs(simulated)
