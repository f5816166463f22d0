"""Levenberg-Marquardt on simulated statistics, with few simulations.

Between iterations the derivatives are kept up to date by Broyden's rank-one formula instead of
being taken anew. A pseudo-Huber loss limits the influence of statistics that the model cannot
reach. The mean level alone is bounded.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.free_parameters import FreeParameter, positions, with_values
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import STIFF, State, beyond, root_weights, stiff, unseen
from dnanalyze.fitting.ties import misfits
from dnanalyze.fitting.vectors import Target

HOPE = 3.0  # times its promise, what the steps after a step may still bring
KEPT = 4 / 3  # factor within which a step takes off what true derivatives promise
# Reproducibility SDs by which one unit of a parameter's grid moves the numbers. Steps end on the
# grid, so that libraries of linear algebra whose last bits differ lead to the same models. Off by
# half a unit, the loss is higher by (2^-10 / 2)^2 = 2e-7 a parameter.
GRAIN = 2.0**-10
DAMPING = 1e-2  # of the first step
FIRM = 50.0  # damping beyond which steps are too short to be worth a simulation


def minimise(
    problem: FitProblem,
    state: State,
    iterations: int = 8,
    tolerance: float = 0.01,
    on_state: Callable[[State], None] = lambda _: None,
    below: float = math.inf,
) -> State:
    """Minimise the loss over the free parameters.

    Parameters
    ----------
    problem : FitProblem
    state : State
        Where to begin.
    iterations : int
        Simulations of whole steps at most.
    tolerance : float
        Stop when a step is expected to lower the loss by less than this share of it.
    on_state : callable
        Called with every state that is better.
    below : float
        Loss that must be reached: give up once even steps of `HOPE` times their promise would not.
    """
    if not state.free:
        return replace(state, at_rest=True)
    over = state.loss / len(state.train)
    bounds, ties = problem.train.bounds(over), problem.ties(state.model, state.free, over)
    state = replace(derive(problem, state), at_rest=False, bounds=bounds, ties=ties)
    damping, stale, true = DAMPING, False, False
    for _ in range(iterations):
        step, expected = _step(state, damping)
        while expected < 0 and damping < FIRM:  # cut short, it would take a level beyond its bound
            damping *= 8.0
            step, expected = _step(state, damping)
        if expected < tolerance * state.loss + 0.5:
            return replace(state, at_rest=true)
        if state.loss - HOPE * expected > below:
            break
        here = positions(state.model, state.free)
        there = np.array([k.inside(x) for k, x in zip(state.free, here + step, strict=True)])
        model = with_values(state.model, state.free, there)
        train = problem.fitted_z(model)
        jacobian = _broyden(state.jacobian, train - state.train, there - here)
        # of the loss itself: its squares, as weighted here, promise too little of what lies far off
        follows = state.train + state.jacobian @ (there - here)
        promised = state.merit - replace(state, model=model, train=follows).merit
        moved = replace(
            state, model=model, train=train, unseen=unseen(problem, model), jacobian=jacobian
        )
        if moved.merit < state.merit:
            gained = state.merit - moved.merit
            state = moved
            on_state(state)
            damping = max(damping * (0.2 if gained > 0.5 * expected else 1.0), 1e-4)
            stale, true = False, promised / KEPT < gained < KEPT * promised
        else:
            damping *= 8.0
            true = False
            state = replace(state, jacobian=jacobian)
            if stale and damping > FIRM:
                break
            stale = True
    return state


def _step(state: State, damping: float) -> tuple[np.ndarray, float]:
    """Damped step within the bounds of the parameters, and the fall of the merit that it promises.

    A level that lies beyond its bound, or that the step would take there, is taken to it.
    """
    w = root_weights(state.train, state.weight)
    a = state.jacobian * w[:, None]
    b = state.train * w
    wanted: dict[int, float] = {}  # numbers that are pressed to their bounds, and these
    bounds, follows = state.bounds, state.train
    step = np.zeros(len(state.free))
    ties, off = tied(state)
    for n in range(3):
        out = [int(i) for i in np.flatnonzero(beyond(follows, state.bounds)) if i not in wanted]
        if n and not out:
            break
        for i in out:
            assert bounds is not None
            wanted[i] = float(np.copysign(bounds[i], follows[i]))
        rows, rest = _pressing(state, wanted)
        step = _damped(state, a, b, damping, np.vstack([rows, ties]), np.concatenate([rest, off]))
        follows = state.train + state.jacobian @ step
    promised = float(b @ b - np.sum((b + a @ step) ** 2))
    promised += float(off @ off - np.sum((off + ties @ step) ** 2))
    return step, promised + stiff(state.train, state.bounds) - stiff(follows, state.bounds)


def within_reach(state: State, wanted: float) -> bool:
    """Whether a loss is within reach of a step, by the known derivatives."""
    _, expected = _step(replace(state, jacobian=np.nan_to_num(state.jacobian)), DAMPING)
    return state.loss - HOPE * expected <= wanted


def tied(state: State) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives and misfits of the ties: derivatives · step + misfits after a step."""
    rows = np.zeros((len(state.ties), len(state.free)))
    for n, tie in enumerate(state.ties):
        rows[n, tie.at] = 1.0 / tie.error
    return rows, misfits(state.ties, positions(state.model, state.free))


def _pressing(state: State, wanted: dict[int, float]) -> tuple[np.ndarray, np.ndarray]:
    """Weighted equations, rows · step + numbers = 0, that move levels within their bounds."""
    at = list(wanted)
    weight = [math.sqrt(STIFF) / abs(x) for x in wanted.values()]
    rows = np.reshape(weight, (-1, 1)) * state.jacobian[at]
    return rows, (state.train[at] - list(wanted.values())) * weight


def _damped(
    state: State,
    a: np.ndarray,
    b: np.ndarray,
    damping: float,
    rows: np.ndarray,
    rest: np.ndarray,
) -> np.ndarray:
    """Step that lowers a step + b and rows step + rest, damped in proportion to ``a`` alone."""
    size = np.sqrt(np.sum(a * a, axis=0))
    usable = size > 1e-6
    grid = GRAIN / np.exp2(np.ceil(np.log2(np.where(usable, size, 1.0))))
    here = positions(state.model, state.free)
    step = np.zeros(len(here))
    for _ in range(3):  # a parameter pushed against its bound stays there
        step = grid * np.rint(_marquardt(a, b, size, usable, damping, rows, rest) / grid)
        step = np.clip(step, *longest(state.free, here))
        held = np.array(
            [
                (k.inside(x + s) == x and abs(s) > 0)
                for k, x, s in zip(state.free, here, step, strict=True)
            ]
        )
        if not (held & usable).any():
            break
        usable = usable & ~held
    return step


def longest(free: Sequence[FreeParameter], here: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Longest step: a factor of 4 on a log scale, .15 eV, or a few times a linear value."""
    reach = np.array(
        [
            1.4 if k.log else 0.15 if k.part == "ea_ev" else 2 * abs(x) + 0.5
            for k, x in zip(free, here, strict=True)
        ]
    )
    return -reach, reach


def _broyden(jacobian: np.ndarray, change: np.ndarray, step: np.ndarray) -> np.ndarray:
    norm = float(step @ step)
    if norm == 0:
        return jacobian
    return jacobian + np.outer(change - jacobian @ step, step) / norm


def linear_step(
    state: State, fitted: Target, held_out: Target, train: np.ndarray, test: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Misfits after the step of the parameters that lowers those on the fitted half.

    The derivatives are those of the state: all sensors of one design share them.

    Parameters
    ----------
    state : State
    fitted, held_out : Target
        The two halves.
    train, test : ndarray
        Misfits on either, in reproducibility SDs, (sensors, statistics).
    """
    jacobian = np.nan_to_num(state.jacobian)  # what no fit has moved yet absorbs nothing
    weights = [root_weights(z, state.weight) for z in train]
    steps = [_first_step(jacobian * w[:, None], z * w) for z, w in zip(train, weights, strict=True)]
    taken = np.reshape(steps, (len(train), jacobian.shape[1]))
    elsewhere = fitted.derivatives_of(held_out, jacobian)
    return train + taken @ jacobian.T, test + taken @ elsewhere.T


def _first_step(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The first step of a fit that lowers a step + b."""
    size = np.sqrt(np.sum(a * a, axis=0))
    return _marquardt(a, b, size, size > 0.0, DAMPING)


def _marquardt(
    a: np.ndarray,
    b: np.ndarray,
    size: np.ndarray,
    usable: np.ndarray,
    damping: float,
    rows: np.ndarray | None = None,
    rest: Sequence[float] | np.ndarray = (),
) -> np.ndarray:
    """Step that lowers a step + b, and rows step + rest (Levenberg and Marquardt).

    ``size``: norms of the columns of ``a``, by which they are scaled; ``usable``: those that move.
    """
    scaled = a[:, usable] / size[usable]
    normal, slope = scaled.T @ scaled + damping * np.eye(scaled.shape[1]), scaled.T @ b
    if rows is not None and len(rest):
        pressing = rows[:, usable] / size[usable]
        normal, slope = normal + pressing.T @ pressing, slope + pressing.T @ rest
    step = np.zeros(size.size)
    step[usable] = np.linalg.solve(normal, -slope) / size[usable]
    return step
