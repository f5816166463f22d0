"""Fits that begin on a part of the field.

What every part shows alike can be fitted to a quarter of the field, in less than half of the time.
The whole field then begins near the end, with derivatives nearly as good as those of another
simulated sensor.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import State, derive, minimise, start
from dnanalyze.fitting.predictor import Bench
from dnanalyze.fitting.time_limit import TimeLimit, TimeUp
from dnanalyze.model.effect import Placing
from dnanalyze.model.noise_model import NoiseModel


def part_for(bench: Bench, model: NoiseModel) -> Bench | None:
    """The part of the field on which a model may be fitted first; None where it may not."""
    return bench.part if model.placing is Placing.EVERYWHERE else None


def fitted(
    bench: Bench, model: NoiseModel, fit: Callable[[Bench, State], State] = minimise
) -> State:
    """A model fitted to the part first, where it may be.

    Parameters
    ----------
    bench : Bench
    model : NoiseModel
        Where to begin.
    fit : callable
        What is done on the whole field.
    """
    part = part_for(bench, model)
    if part is None:
        return fit(bench, start(bench, model, knobs_of(model)))
    near = minimise(part, start(part, model, knobs_of(model)))
    return fit(bench, carried(near, part, bench))


def fitted_in_time(bench: Bench, model: NoiseModel) -> State:
    """`fitted`, or where it stood when the time was up."""
    so_far: list[State] = []
    try:
        return fitted(bench, model, partial(minimise, tell=so_far.append))
    except TimeUp:
        pass
    return so_far[-1] if so_far else start(bench.within(TimeLimit()), model, knobs_of(model))


def carried(state: State, there: Bench, here: Bench) -> State:
    """The model of a state, with its derivatives, from the part to the whole or back.

    A statistic's derivative is the same but for its floor; of one that only one of them has, it is
    taken to be 0.
    """
    begun = start(here, state.model, state.knobs)
    return replace(begun, jacobian=_derivatives(state, there, here))


def derived_anew(bench: Bench, state: State) -> State:
    """The state with all derivatives taken anew, on the part where they may be."""
    part = part_for(bench, state.model)
    if part is None:
        return derive(bench, state, anew=True)
    near = derive(part, carried(state, bench, part), anew=True)
    return replace(state, jacobian=_derivatives(near, part, bench))


def _derivatives(state: State, there: Bench, here: Bench) -> np.ndarray:
    """Those of a state on one of the two, as they are on the other."""
    row = {key: i for i, key in enumerate(there.train.keys)}
    rows = np.array([row.get(key, -1) for key in here.train.keys])
    known = rows >= 0
    scale = there.train.floor[rows[known]] / here.train.floor[known]
    jacobian = np.zeros((len(here.train.keys), len(state.knobs)))
    jacobian[known] = state.jacobian[rows[known]] * scale[:, None]
    return jacobian
