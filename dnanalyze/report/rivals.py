"""Further models on the held-out half: before and after an effect, without filters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.comparator.compare import table
from dnanalyze.diagnosis.filter_tests import FILTERS
from dnanalyze.diagnosis.results import Diagnosis, Step
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.model.noise_model import NoiseModel


@dataclass(frozen=True)
class Rival:
    """A model, its statistics, and its rows of a comparison with the captures.

    Parameters
    ----------
    model : NoiseModel
    statistics : Statistics
        Simulated, of the held-out half, with their curves.
    rows : list of dict
        As ``Comparison.statistics``.
    """

    model: NoiseModel
    statistics: Statistics
    rows: list[dict[str, Any]]


@dataclass(frozen=True)
class Rivals:
    """The models beside a comparison's; each may be absent.

    Parameters
    ----------
    effect : str
        The named effect; "" where there is none.
    before, after : Rival, optional
        The models of the steps without and with it.
    raw : Rival, optional
        The compared model without its filters.
    """

    effect: str = ""
    before: Rival | None = None
    after: Rival | None = None
    raw: Rival | None = None


def rival(problem: FitProblem, model: NoiseModel | None) -> Rival | None:
    """A model on the held-out half of these captures."""
    if model is None:
        return None
    made = problem.statistics(model, errors=True)
    return Rival(model, made[1], table(problem, made))


def unfiltered(problem: FitProblem, model: NoiseModel | None) -> Rival | None:
    """The model without defect correction and denoise; None where it has none."""
    filters = [n for n in FILTERS if model is not None and model.get(n) is not None]
    if model is None or not filters:
        return None
    for name in filters:
        model = model.without(name)
    return rival(problem, model)


def of_steps(problem: FitProblem, steps: Sequence[Step], named: Sequence[str]) -> Rivals:
    """Of a refinement: the named effect with the largest fall of the error, before and after it."""
    places = [n for n, s in enumerate(steps) if n and s.added in named and steps[n - 1].model]
    model = steps[-1].model
    if not places:
        return Rivals(raw=unfiltered(problem, model))
    place = max(places, key=lambda n: steps[n - 1].error - steps[n].error)
    return Rivals(
        str(steps[place].added),
        rival(problem, steps[place - 1].model),
        rival(problem, steps[place].model),
        unfiltered(problem, model),
    )


def of_diagnosis(problem: FitProblem, found: Diagnosis) -> Rivals:
    """Of a diagnosis: the model, and with the leading candidate."""
    effect = found.candidates[0].effect if found.candidates else ""
    trial = next((t for t in found.trials if t.effect == effect), None)
    raw = unfiltered(problem, found.model)
    if trial is None:
        return Rivals(raw=raw)
    return Rivals(effect, rival(problem, found.model), rival(problem, trial.state.model), raw)
