"""Restart of amplitudes that a fit reduced until the statistics do not depend on them.

The derivative with respect to the logarithm of an amplitude goes as the amplitude itself. A fit
that once makes it small therefore stays there. Such an amplitude is raised until the statistics
show it, and begins again where the linear change from nothing to there lowers the loss most.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from dnanalyze.fitting.changes import Changes
from dnanalyze.fitting.derivatives import GROWTH, SMALLEST, placing_of
from dnanalyze.fitting.free_parameters import (
    FreeParameter,
    grouped,
    positions,
    settings_of,
    with_values,
)
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State, root_weights, start
from dnanalyze.model.effect import Placing
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.significance import LEAST_GAIN

RISE = math.log(GROWTH)  # of an amplitude that is raised, each time
RISES = 6  # to 2.6e5 times


def restarted(problem: FitProblem, state: State, iterations: int) -> State:
    """The state, or a better one with such amplitudes restarted.

    Parameters
    ----------
    problem : FitProblem
    state : State
        At rest, its derivatives known.
    iterations : int
        Of the fit from there.
    """
    lost = _lost(problem, state) if state.free else []
    if not lost:
        return state
    there = _where_it_helps(problem, state, lost)
    if not there:
        return state
    where = positions(state.model, state.free)
    jacobian = state.jacobian.copy()
    for i, x in there.items():
        where[i] = x
        jacobian[:, i] = np.nan
    begun = start(problem, with_values(state.model, state.free, where), state.free)
    ended = minimise(problem, replace(begun, jacobian=jacobian), iterations)
    return ended if ended.merit < state.merit - LEAST_GAIN else state


def _lost(problem: FitProblem, state: State) -> list[int]:
    """Logarithmic amplitudes on which the statistics do not depend."""
    here = positions(state.model, state.free)
    may = [i for i, k in enumerate(state.free) if _may_be_lost(problem, k, here[i])]
    placed: dict[Placing, list[list[int]]] = {}
    for members in grouped(state.free, may):
        placing = placing_of(state.model, state.free[members[0]])
        placed.setdefault(placing, []).append(members)
    found = []
    for placing, groups in placed.items():
        changes = Changes.of(problem, state.model, placing)
        models = [_lowered(state, here, members) for members in groups]
        for members, change in zip(groups, changes.by(models), strict=True):
            sizes = [np.linalg.norm(_own(problem, state, i, change)) for i in members]
            found += [i for i, size in zip(members, sizes, strict=True) if size < SMALLEST]
    return sorted(found)


def _lowered(state: State, here: np.ndarray, members: Sequence[int]) -> NoiseModel:
    """The model with some amplitudes an eighth of what they are."""
    there = here.copy()
    for i in members:
        there[i] = state.free[i].inside(here[i] - RISE)
    return with_values(state.model, state.free, there)


def _may_be_lost(problem: FitProblem, parameter: FreeParameter, position: float) -> bool:
    """Whether a parameter is the logarithm of a level, a noise or a gain small enough to be lost.

    A level or a noise above that of the quietest pixels shows; of a gain nothing is known.
    """
    if not parameter.logarithmic:
        return False
    noise = problem.train.values[problem.train.names == "temporal_noise_core"]
    if parameter.unit in ("DN", "ln DN"):
        return noise.size > 0 and math.exp(position) < float(noise.min())
    return parameter.unit == "DN/e-"


def _own(problem: FitProblem, state: State, at: int, change: np.ndarray) -> np.ndarray:
    """A change at the settings that a parameter moves."""
    mask = settings_of(state.free[at], state.model, problem.plan.settings)
    return np.where(mask[problem.train.setting], change, 0.0)


def _where_it_helps(problem: FitProblem, state: State, lost: Sequence[int]) -> dict[int, float]:
    """Positions of the parameters at which the loss is expected to fall; others are left out."""
    here = positions(state.model, state.free)
    found: dict[int, float] = {}
    for members in grouped(state.free, lost):
        for n in range(1, RISES + 1):
            raised = here.copy()
            for i in members:
                raised[i] = state.free[i].inside(here[i] + n * RISE)
            moved = problem.fitted_z(with_values(state.model, state.free, raised)) - state.train
            seen = []
            for i in members:
                change = _own(problem, state, i, moved)
                if np.linalg.norm(change) >= SMALLEST:
                    seen.append(i)
                    share = _best_share(state, change, lost)
                    if share > 0.0:
                        plain = math.exp(here[i]), math.exp(raised[i])
                        found[i] = math.log(plain[0] + share * (plain[1] - plain[0]))
            members = [i for i in members if i not in seen]
            if not members:
                break
    return found


def _best_share(state: State, change: np.ndarray, lost: Sequence[int]) -> float:
    """Share of a change, 0 to 1, that lowers the weighted squares most; 0 where that is nothing.

    The free parameters that are not lost follow linearly.
    """
    w = root_weights(state.train, state.weight)
    others = np.delete(np.nan_to_num(state.jacobian), list(lost), axis=1)
    others = others[:, np.linalg.norm(others, axis=0) > 1e-6] * w[:, None]
    free = np.linalg.qr(others)[0] if others.size else np.zeros((w.size, 0))
    step, rest = (x - free @ (free.T @ x) for x in (change * w, state.train * w))
    size = float(step @ step)
    share = -float(step @ rest) / size if size > 0.0 else 0.0
    return min(share, 1.0) if share > 0.0 and share**2 * size > LEAST_GAIN else 0.0
