"""Finite-difference derivatives of the predictions, one simulation per group of parameters.

An effect that is everywhere changes a part of the field as it changes the whole. Its parameters are
varied on the part, at about a third of the time; those of an effect with a place, or in few pixels,
on the whole.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from dnanalyze.fitting.free_parameters import (
    PEDESTAL,
    FreeParameter,
    grouped,
    positions,
    settings_of,
    with_values,
)
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State, carried, evened
from dnanalyze.loaders.thermometer import tells_slope
from dnanalyze.model.effect import Placing
from dnanalyze.model.noise_model import NoiseModel

# Useful size of a derivative step, reproducibility SDs (Euclidean). Pixels that cross an edge of a
# code jump, and the statistics with them, by some SDs however short the step.
SMALLEST, LARGEST = 12.0, 400.0
SEVERAL = 3  # derivatives beyond which it pays to begin from half of the field
GROWTH = 8.0  # of a step or an amplitude that shows too little, each time


def derive(
    problem: FitProblem,
    state: State,
    only: Callable[[FreeParameter], bool] = lambda _: True,
    smallest: float = SMALLEST,
    anew: bool = False,
) -> State:
    """Compute the derivatives that are not known yet, one simulation per group of parameters.

    A first step that moves the numbers by less than ``smallest`` SDs is taken again, longer.
    ``anew``: also those that are known, which then tell how long a step must be.
    """
    open_yet = np.isnan(state.jacobian).any(axis=0) | anew
    wanted = [i for i, k in enumerate(state.free) if open_yet[i] and only(k)]
    jacobian = state.jacobian.copy()
    near: list[list[int]] = []
    far: list[list[int]] = []
    for members in grouped(state.free, wanted):
        parameter = state.free[members[0]]
        if not _determined(problem, state.model, parameter):
            jacobian[:, members] = 0.0
        elif problem.part is not None and placing_of(state.model, parameter) is Placing.EVERYWHERE:
            near.append(members)
        else:
            far.append(members)
    if near and problem.part is not None:
        there = carried(state, problem, problem.part)
        seen = _differences(problem.part, there, near, smallest)
        columns = problem.part.train.derivatives_of(problem.train, np.stack(list(seen.values()), 1))
        jacobian[:, list(seen)] = columns
    alone, begun = evened(problem, state) if len(far) > SEVERAL else (problem, state)
    for i, column in _differences(alone, begun, far, smallest).items():
        jacobian[:, i] = column
    return replace(state, jacobian=jacobian)


def placing_of(model: NoiseModel, parameter: FreeParameter) -> Placing:
    """Where in the field a parameter acts: the black level does everywhere."""
    effect = model.get(parameter.effect)
    return Placing.EVERYWHERE if effect is None else effect.placing


def _determined(problem: FitProblem, model: NoiseModel, parameter: FreeParameter) -> bool:
    """Whether the statistics of the fitted half depend on a parameter.

    Not on those of what lies in the held-out half alone, nor on an activation energy where the
    temperatures are too near each other.
    """
    effect = model.get(parameter.effect)
    if parameter.energy and not tells_slope(p.temperature_c for p, _ in problem.plan.settings):
        return False
    return effect is None or effect.lies_in(problem.plan.windows[0])


def _differences(
    problem: FitProblem, state: State, groups: list[list[int]], smallest: float
) -> dict[int, np.ndarray]:
    """Columns of groups of parameters, by one-sided steps sized to be seen but not large."""
    here = positions(state.model, state.free)
    first = np.array([_first_step(k, x) for k, x in zip(state.free, here, strict=True)])
    known = np.linalg.norm(state.jacobian, axis=0)  # NaN where not known
    step = first * np.where(np.isnan(known), 1.0, _rescaled(known * first, smallest))
    columns: dict[int, np.ndarray] = {}
    for least in (smallest, SMALLEST / 4, SMALLEST / 8):
        if not groups:
            break
        there = [_moved(state.free, here, step, members) for members in groups]
        found = problem.several([with_values(state.model, state.free, x) for x in there])
        masks = [settings_of(k, state.model, problem.plan.settings) for k in state.free]
        again = []
        for members, x, coordinates in zip(groups, there, found, strict=True):
            change = problem.train.z(coordinates) - state.train
            for i in members:
                moved = masks[i][problem.train.setting]
                columns[i] = np.where(moved, change, 0) / (
                    state.free[i].change(here[i], x[i]) or 1.0
                )
                size = float(np.linalg.norm(change[moved]))
                longer = min(step[i] * float(_rescaled(size, least)), GROWTH**2 * first[i])
                if longer != step[i] and members not in again:
                    again.append(members)
                step[i] = longer
        groups = again
    return columns


def _moved(
    free: Sequence[FreeParameter], here: np.ndarray, step: np.ndarray, members: Sequence[int]
) -> np.ndarray:
    """Positions with those of a group a step further, within their bounds."""
    there = here.copy()
    for i in members:
        there[i] = free[i].inside(here[i] + step[i])
        if there[i] == here[i]:  # at its upper bound: step down
            there[i] = free[i].inside(here[i] - step[i])
    return there


def _rescaled(size: np.ndarray | float, least: float) -> np.ndarray:
    """Factor for steps of which the numbers moved by ``size`` SDs; 1 where that is right."""
    longer = np.clip(np.rint(12.0 * least / np.maximum(size, 1e-9)) / 8.0, 2.0, GROWTH)
    return np.where(size < least, longer, np.where(size > LARGEST, 0.2, 1.0))


def _first_step(parameter: FreeParameter, position: float) -> float:
    if parameter.log:
        return 0.08
    if parameter.part == "ea_ev":
        return 0.02
    if parameter.effect == PEDESTAL:
        return 0.1
    return 0.05 * max(abs(position), 0.02)
