"""The best form of an effect in a model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import reduce

import numpy as np

from dnanalyze.comparator.predictive_check import FittedModel, error_of
from dnanalyze.diagnosis.nuisance import least_noise, other_strengths, unbiased, without_biased
from dnanalyze.diagnosis.score_test import informative, restricted
from dnanalyze.diagnosis.selection import EVIDENCE_NULL, LEAST_GAIN, REFITS, Trial
from dnanalyze.errors import InputError
from dnanalyze.fitting.changes import screening_part
from dnanalyze.fitting.free_parameters import free_parameters
from dnanalyze.fitting.from_part import FIT_STEPS
from dnanalyze.fitting.least_squares import minimise, within_reach
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State, carried, deviance, start, with_derivatives_of
from dnanalyze.model.noise_model import NoiseModel

# Squared misfit between two predictions: a likelihood ratio of e^(1/2) at most
INDISTINGUISHABLE = 1.0
# Properties of the converter, the mosaic, the pixels and the readout: the frames show them, or,
# of the gain, first guesses have both forms where there are several
UNTRIED = ("bits", "step", "spacing", "shared", "together", "added")


def completed(problem: FitProblem, found: Trial) -> State:
    """The model with the best form and strength of an effect.

    Where the model error is above 1 or replicates reject the model, so that a better one can be
    told from it, other forms are tried until none of them is better. A candidate that is judged by
    sensors of its design stays as it is: forms are compared on one sensor.
    """

    def better_is_told(state: State) -> bool:
        return error_of(problem, state) > 1.0 or not FittedModel.of(problem, state).adequate

    while not (found.formed or found.by_design) and better_is_told(found.state):
        better = in_best_form(problem, found)
        if better is found.state:
            break
        found = replace(found, state=better, others=())
    return found.state


def in_best_form(problem: FitProblem, found: Trial) -> State:
    """The state, or a better one with another form of the effect.

    Other choices of the effect, other strengths, and its other first guesses are simulated once;
    the ones that may be better (see `_promising`) are refitted. Of a model without a place a part
    of the field rules out most: refitted to that, they end above the best of all.
    """
    part = screening_part(problem, found.state.model)
    if part is None:
        return reduce(preferred, _refitted(problem, found), found.state)
    near = replace(found, state=carried(found.state, problem, part))
    better, ended = found.state, _refitted(part, near)
    least = min(state.loss for state in (near.state, *ended))
    reach = least + EVIDENCE_NULL * max(1.0, least / len(near.state.train))
    for state in sorted(ended, key=lambda state: state.loss):
        if state.loss <= reach:
            begun = carried(state, part, problem)
            better = preferred(better, minimise(problem, begun, FIT_STEPS, below=better.loss))
    return better


def _refitted(problem: FitProblem, found: Trial) -> list[State]:
    """Other forms of the effect of a trial, each refitted while it may be better than the last."""
    state = found.state
    known = {found.effect, *state.model.names}
    noise = least_noise(problem)
    forms = [g.model for g in found.others if set(g.model.names) == known]
    forms += _forms(state.model, found.effect, noise)
    strengths = other_strengths(state.model, found.effect, noise)
    better, made = state, []
    for model in _promising(problem, state, forms, list(strengths))[:REFITS]:
        begun = without_biased(problem, start(problem, model, like=state), found.effect)
        made.append(minimise(problem, begun, FIT_STEPS, below=better.loss))
        better = preferred(better, made[-1])
    return made


def _promising(
    problem: FitProblem,
    state: State,
    forms: Sequence[NoiseModel],
    strengths: Sequence[NoiseModel] = (),
) -> list[NoiseModel]:
    """The models from which, by the derivatives of a state, its loss is within reach, lowest first.

    Before them the lowest of the other forms, whose derivatives are not those of the state. At the
    two most informative operating points. Models whose predictions do not differ from the state's
    in the captures are no other forms: of a window, a glow of corners beyond it.
    """
    settings = informative(problem, state)
    few, own = problem.only(settings), restricted(problem, state, settings)
    models = list(dict.fromkeys([*forms, *strengths]))
    begun = []
    for model, found in zip(models, few.several(models), strict=True):
        there = replace(own, model=model, free=free_parameters(model), train=few.train.z(found))
        begun.append(with_derivatives_of(there, own))
    other = [s for s in begun if np.sum((s.train - own.train) ** 2) > INDISTINGUISHABLE]
    other.sort(key=lambda s: s.loss)
    first = [s.model for s in other if s.model in forms][:1]
    near = [s.model for s in other if within_reach(s, own.loss)]
    return list(dict.fromkeys(first + near))


def _forms(model: NoiseModel, name: str, noise: float) -> Iterator[NoiseModel]:
    """The model with each other choice of an effect, and with its relatives."""
    effect = model.get(name)
    assert effect is not None
    others = list(effect.relatives())
    for choice, info in effect.parameters().items():
        if info.scale == "choice" and choice not in (*UNTRIED, *effect.inactive_parameters()):
            for other in info.choices:
                if other != getattr(effect, choice):
                    with suppress(InputError):  # a choice that the others rule out
                        others.append(replace(effect, **{choice: other}))
    for other in others:
        with suppress(InputError):
            yield (unbiased(model, other, noise, effect) or model).with_effect(other)


def preferred(state: State, other: State) -> State:
    """The other where it gains more than is worth a refit, in the mean of both halves."""
    was, now = (np.sum(deviance(s.test)) + np.sum(deviance(s.train)) for s in (state, other))
    return other if (was - now) / 2.0 > LEAST_GAIN else state
