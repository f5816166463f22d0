"""Baseline effects, which every sensor has; they enter a model as one step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from dnanalyze.diagnosis.selection import DEFLATION
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.from_part import converge, fitted
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASELINE, WANG

BASELINE_REASON = (
    "baseline effect, present in every sensor: added with the other baseline effects, untested"
)
FAR_OFF = 5.0  # loss per statistic beyond which the next effect moves all that is fitted here


def far_off(state: State) -> bool:
    """Whether the loss per statistic is so large that the next effect changes all parameters."""
    return state.loss > FAR_OFF * len(state.train)


def lacks_baseline(model: NoiseModel, exclude: Sequence[str] = ()) -> bool:
    """Whether a model has none of the baseline effects that are not excluded, but the converter."""
    wanted = any(name not in exclude and model.get(name) is None for name in BASELINE)
    return wanted and all(name in WANG or model.get(name) is None for name in BASELINE)


def baseline_start(problem: FitProblem, exclude: Sequence[str] = (), seed: int = 0) -> NoiseModel:
    """The model with the baseline effects that are not excluded, from moments of the frames."""
    begun = baseline_model(problem)
    for name in exclude:
        begun = begun.without(name)
    return replace(begun, seed=seed)


def baseline_fitted(problem: FitProblem, begun: NoiseModel) -> State:
    """All baseline effects fitted together: without one of them the others take its share."""
    fit = partial(converge, hopeless=FAR_OFF, settled=DEFLATION, last=False)
    return fitted(problem, begun, fit)


def reasons(effect: Effect) -> list[str]:
    """Why a baseline effect is in a model, and in the form that it has."""
    if isinstance(effect, ReadNoise) and effect.shared_pixels != (1, 1):
        shared = (
            f"pixels of {effect.shared} (rows x columns) share an amplifier: their temporal "
            "variances are correlated, those of pixels across the groups are not"
        )
        return [BASELINE_REASON, shared]
    return [BASELINE_REASON]


def new_in(model: NoiseModel, before: NoiseModel) -> list[str]:
    """Baseline effects of a model that another one has not."""
    return [n for n in BASELINE if model.get(n) is not None and before.get(n) is None]
