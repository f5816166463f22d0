"""Nuisance parameters: correction for the bias that a missing effect causes.

A fit without a temporal filter makes the read noise small instead, and one without a digital gain
makes every noise large. A candidate of that kind is tested beside parameters that no longer make up
for it: by its own factors (`Effect.nuisance_bias`), or by the moments of the frames less what it
adds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.free_parameters import FreeParameter, free_parameters, positions, with_values
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State
from dnanalyze.model.effect import Effect, Stage
from dnanalyze.model.guesses.evidence import quietest
from dnanalyze.model.laws import Law, TableLaw, value_at
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE, BASELINE

UNBIASED = (1.0, 0.0)  # factor and offset


def least_noise(problem: FitProblem) -> float:
    """Temporal noise of the operating point with the least, DN; infinite where there is none."""
    train = problem.train
    values = train.values[train.names == "temporal_noise"]
    return float(values[quietest(values)]) if values.size else math.inf


def unbiased(
    model: NoiseModel, effect: Effect, noise: float, other: Effect | None = None
) -> NoiseModel | None:
    """A model with its parameters corrected for the bias by an effect.

    None where it biases none of them. ``model``: as fitted without the effect, or with it as
    ``other`` states. ``noise``: of the operating point with the least, DN.
    """
    free = free_parameters(model)
    plain = [k.plain(x) for k, x in zip(free, positions(model, free), strict=True)]
    right = []
    for x, parameter in zip(plain, free, strict=True):
        factor, shift = bias(effect, parameter, model, noise)
        was, moved = UNBIASED if other is None else bias(other, parameter, model, noise)
        same = (factor, shift) == (was, moved) or not was
        right.append(x if same else factor * (x - moved) / was + shift)
    if right == plain:
        return None
    where = [k.inside(k.position(x)) for k, x in zip(free, right, strict=True)]
    return with_values(model, free, np.array(where))


def bias(
    effect: Effect, parameter: FreeParameter, model: NoiseModel, noise: float
) -> tuple[float, float]:
    """Factor and shift that correct a parameter of a model without an effect.

    The parameters of what acts on codes are right as they are.
    """
    bearer = model.get(parameter.effect)
    if parameter.effect == effect.name or (bearer is not None and bearer.stage > Stage.CONVERTER):
        return UNBIASED
    return effect.nuisance_bias(parameter.name, parameter.unit, noise)


def without_biased(problem: FitProblem, state: State, name: str) -> State:
    """A state without the derivatives of an effect and of what it biases: they change with it."""
    effect, noise = state.model.get(name), least_noise(problem)
    assert effect is not None
    moved = [
        k.effect == name or bias(effect, k, state.model, noise) != UNBIASED for k in state.free
    ]
    return replace(state, jacobian=np.where(moved, np.nan, state.jacobian))


def from_moments(problem: FitProblem, model: NoiseModel, effect: Effect) -> NoiseModel | None:
    """The baseline model by the moments of the frames less the contribution of an effect.

    None where the effect does not state what it adds.
    """
    shape = problem.plan.shape
    if any(effect.adds(p, model.reference, shape) is None for p, _ in problem.plan.settings):
        return None
    begun = baseline_model(problem, effect)
    for name in (BASE, *BASELINE):
        other = begun.get(name)
        if other is not None and model.get(name) is not None:
            model = model.with_effect(other)
    return replace(model, pedestal=_less_shift(begun.pedestal, model.with_effect(effect), shape))


def _less_shift(black: Law, model: NoiseModel, shape: tuple[int, int]) -> Law:
    """The pedestal with which a model shows a black level."""
    if isinstance(black, TableLaw):
        pairs = zip(black.points, black.values, strict=True)
        return replace(black, values=tuple(v - model.black_shift(p, shape) for p, v in pairs))
    return value_at(black, model.reference) - model.black_shift(model.reference, shape)


def other_strengths(model: NoiseModel, name: str, noise: float) -> Iterator[NoiseModel]:
    """The model at half and twice each number of an effect, with the parameters it biases.

    Strength and bias move together, far and along a curve that steps of a fit do not follow.
    """
    effect = model.get(name)
    assert effect is not None
    for parameter, info in effect.parameters().items():
        value = getattr(effect, parameter)
        free = (
            info.scale not in ("choice", "held") and parameter not in effect.inactive_parameters()
        )
        if not (free and isinstance(value, (int, float))):
            continue
        for factor in (0.5, 0.7, 1.4, 2.0):
            at = min(max(value * factor, info.lower), info.upper)
            other = replace(effect, **{parameter: at})
            rest = unbiased(model, other, noise, effect) if at != value else None
            if rest is not None:
                yield rest.with_effect(other)
