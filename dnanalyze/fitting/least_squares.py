"""Levenberg-Marquardt on simulated statistics, with few simulations.

The derivative of a group of knobs costs one simulation; between iterations it is kept up to date by
Broyden's rank-one formula instead of being taken anew. A pseudo-Huber loss keeps a few statistics
that the model cannot reach from bending all others. The mean level alone is held within bounds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from dnanalyze.fitting.knobs import PEDESTAL, Knob, positions, settings_of, turned
from dnanalyze.fitting.predictor import Bench
from dnanalyze.fitting.ties import Tie, misfits
from dnanalyze.loaders.thermometer import tells_slope
from dnanalyze.model.noise_model import NoiseModel

SCALE = 6.0  # of the loss, in floors: a difference beyond it counts in proportion, not squared
HOPE = 3.0  # times its promise, what the steps after a step may still bring
KEPT = 4 / 3  # factor within which a step takes off what true derivatives promise
# Useful size of a derivative step, floors (Euclidean). Pixels that cross a code's edge jump,
# and the statistics with them, by some floors however short the step: less would be lost in it.
SMALLEST, LARGEST = 12.0, 400.0
SEVERAL = 3  # derivatives beyond which it pays to begin from half of the field
GROWTH = 8.0  # of a step that shows too little, each time; twice at most
# Floors that one unit of a knob's grid moves the numbers by. Steps end on the grid, so that
# libraries of linear algebra whose last bits differ lead to the same models. Off by half a unit,
# the loss is higher by (2^-10 / 2)^2 = 2e-7 a knob.
GRAIN = 2.0**-10
# Weight of the square of what a level lies beyond its bound, in bounds. On a real CCD the other
# statistics gained 2,200 by four bounds of the level: they put it some percent beyond. Where bounds
# cannot all be kept, half a bound beyond costs 2,500: no more than much else that is wrong there.
STIFF = 1e4
DAMPING = 1e-2  # of the first step
FIRM = 50.0  # damping beyond which steps are too short to be worth a simulation


@dataclass(frozen=True)
class State:
    """A model with what it predicts and how that moves with its knobs.

    Parameters
    ----------
    model : NoiseModel
    knobs : list of Knob
    train : ndarray
        Differences in floors on the fitted half.
    unseen : callable
        Those on the judged half: simulated when first asked for, which no step of a fit does.
    jacobian : ndarray
        d train / d knob, (numbers, knobs); NaN columns are not known yet.
    at_rest : bool
        Whether a fit has ended here because its derivatives, which its last step showed to be true,
        promise no more.
    bounds : ndarray, optional
        Of each train number, in floors: how far it may be off, inf where that is left to the loss.
    ties : tuple of Tie
        Constraints of knobs by direct measurements.
    """

    model: NoiseModel
    knobs: list[Knob]
    train: np.ndarray
    unseen: Callable[[], np.ndarray]
    jacobian: np.ndarray
    at_rest: bool = False
    bounds: np.ndarray | None = None
    ties: tuple[Tie, ...] = ()

    @property
    def test(self) -> np.ndarray:
        """Differences in floors on the judged half."""
        return self.unseen()

    @property
    def loss(self) -> float:
        """Pseudo-Huber loss over the train numbers (a sum of squares for small ones)."""
        return loss(self.train)

    @property
    def merit(self) -> float:
        """What a fit lowers: the loss, with what bounds that are not kept and the ties add."""
        off = misfits(self.ties, positions(self.model, self.knobs)) if self.ties else np.zeros(1)
        return merit(self.train, self.bounds) + float(off @ off)


def unseen(bench: Bench, model: NoiseModel) -> Callable[[], np.ndarray]:
    """What a state needs to tell of the judged half."""
    return cache(partial(bench.judged_z, model))


def given(z: np.ndarray) -> Callable[[], np.ndarray]:
    """The same of differences that are known."""
    return lambda: z


def deviance(z: np.ndarray) -> np.ndarray:
    """Pseudo-Huber loss 2 c^2 (sqrt(1 + (z/c)^2) - 1) of each: z^2 well below c, 2 c |z| above."""
    return np.asarray(2 * SCALE**2 * (np.sqrt(1 + (z / SCALE) ** 2) - 1))


def loss(z: np.ndarray) -> float:
    """Sum of the deviance, which a fit minimises."""
    return float(np.sum(deviance(z)))


def merit(z: np.ndarray, bounds: np.ndarray | None) -> float:
    """Loss, and `STIFF` times the squares of what lies beyond its bound, in bounds."""
    return loss(z) + _stiff(z, bounds)


def _stiff(z: np.ndarray, bounds: np.ndarray | None) -> float:
    return STIFF * float(np.sum(_beyond(z, bounds) ** 2))


def _beyond(z: np.ndarray, bounds: np.ndarray | None) -> np.ndarray:
    """How far numbers lie beyond their bounds, in bounds; 0 within them."""
    return np.zeros(1) if bounds is None else np.maximum(np.abs(z) / bounds - 1.0, 0.0)


def start(bench: Bench, model: NoiseModel, knobs: list[Knob], like: State | None = None) -> State:
    """Simulate a model; take over derivatives from a like model where knobs agree."""
    train = bench.fitted_z(model)
    blank = np.full((len(train), len(knobs)), np.nan)
    over = loss(train) / len(train)
    bounds, ties = bench.train.bounds(over), bench.direct.ties(model, knobs, over)
    begun = State(model, knobs, train, unseen(bench, model), blank, False, bounds, ties)
    return begun if like is None else with_derivatives_of(begun, like)


def with_derivatives_of(state: State, like: State) -> State:
    """The state with a like model's derivatives where knobs agree, and no others."""
    known = {k.name: i for i, k in enumerate(like.knobs)}
    jacobian = np.full_like(state.jacobian, np.nan)
    for i, knob in enumerate(state.knobs):
        if knob.name in known:
            jacobian[:, i] = like.jacobian[:, known[knob.name]]
    return replace(state, jacobian=jacobian)


def evened(bench: Bench, state: State) -> tuple[Bench, State]:
    """The bench without half of the field, where the model lets it be left out, and what it shows.

    Predictions are to be compared with those of this state.
    """
    alone = bench.evened(state.model)
    if alone.even == bench.even:
        return bench, state
    return alone, replace(state, train=alone.fitted_z(state.model))


def derive(
    bench: Bench,
    state: State,
    only: Callable[[Knob], bool] = lambda _: True,
    smallest: float = SMALLEST,
    anew: bool = False,
) -> State:
    """Take the derivatives that are not known yet, one simulation a group of knobs.

    A first step that moves the numbers by less than ``smallest`` floors is taken again, longer.
    ``anew``: also those that are known, which then tell how long a step must be. Of what lies in
    the judged half alone, the fitted one tells nothing, nor do temperatures too near each other of
    an activation energy: there they are 0.
    """
    jacobian = state.jacobian.copy()
    groups: dict[str, list[int]] = {}
    for i, knob in enumerate(state.knobs):
        if (anew or np.isnan(jacobian[:, i]).any()) and only(knob):
            groups.setdefault(knob.group, []).append(i)
    seen = []
    for members in groups.values():
        knob = state.knobs[members[0]]
        effect = state.model.get(knob.effect)
        told = not knob.energy or tells_slope(p.temperature_c for p, _ in bench.plan.settings)
        if told and (effect is None or effect.lies_in(bench.plan.windows[0])):
            seen.append(members)
        else:
            jacobian[:, members] = 0.0
    for i, column in _differences(bench, state, seen, smallest).items():
        jacobian[:, i] = column
    return replace(state, jacobian=jacobian)


def _differences(
    bench: Bench, state: State, groups: list[list[int]], smallest: float
) -> dict[int, np.ndarray]:
    """Columns of groups of knobs, by one-sided steps that are sized to be seen but not large."""
    if len(groups) > SEVERAL:
        bench, state = evened(bench, state)
    here = positions(state.model, state.knobs)
    first = np.array([_first_step(k, x) for k, x in zip(state.knobs, here, strict=True)])
    known = np.linalg.norm(state.jacobian, axis=0)  # NaN where not known
    step = first * np.where(np.isnan(known), 1.0, _rescaled(known * first, smallest))
    columns: dict[int, np.ndarray] = {}
    for least in (smallest, SMALLEST / 4, SMALLEST / 8):
        if not groups:
            break
        there = [_moved(state.knobs, here, step, members) for members in groups]
        found = bench.several([turned(state.model, state.knobs, x) for x in there])
        masks = [settings_of(k, state.model, bench.plan.settings) for k in state.knobs]
        again = []
        for members, x, coordinates in zip(groups, there, found, strict=True):
            change = bench.train.z(coordinates) - state.train
            for i in members:
                moved = masks[i][bench.train.setting]
                columns[i] = np.where(moved, change, 0) / (
                    state.knobs[i].change(here[i], x[i]) or 1.0
                )
                size = float(np.linalg.norm(change[moved]))
                longer = min(step[i] * float(_rescaled(size, least)), GROWTH**2 * first[i])
                if longer != step[i] and members not in again:
                    again.append(members)
                step[i] = longer
        groups = again
    return columns


def _moved(
    knobs: Sequence[Knob], here: np.ndarray, step: np.ndarray, members: Sequence[int]
) -> np.ndarray:
    """Positions with those of a group a step further, within their bounds."""
    there = here.copy()
    for i in members:
        there[i] = knobs[i].inside(here[i] + step[i])
        if there[i] == here[i]:  # at its upper bound: step down
            there[i] = knobs[i].inside(here[i] - step[i])
    return there


def _rescaled(size: np.ndarray | float, least: float) -> np.ndarray:
    """Factor for steps that moved the numbers by ``size`` floors; 1 where that is right."""
    longer = np.clip(np.rint(12.0 * least / np.maximum(size, 1e-9)) / 8.0, 2.0, GROWTH)
    return np.where(size < least, longer, np.where(size > LARGEST, 0.2, 1.0))


def _first_step(knob: Knob, position: float) -> float:
    if knob.log:
        return 0.08
    if knob.part == "ea_ev":
        return 0.02
    if knob.effect == PEDESTAL:
        return 0.1
    return 0.05 * max(abs(position), 0.02)


def minimise(
    bench: Bench,
    state: State,
    iterations: int = 8,
    tolerance: float = 0.01,
    tell: Callable[[State], None] = lambda _: None,
    below: float = math.inf,
) -> State:
    """Move the knobs until the loss no longer falls.

    Parameters
    ----------
    bench : Bench
    state : State
        Where to begin.
    iterations : int
        Simulations of whole steps at most.
    tolerance : float
        Stop when a step is expected to lower the loss by less than this share of it.
    tell : callable
        Called with every state that is better.
    below : float
        Loss that must be reached: give up once even steps of `HOPE` times their promise would not.
    """
    if not state.knobs:
        return replace(state, at_rest=True)
    over = state.loss / len(state.train)
    bounds, ties = bench.train.bounds(over), bench.direct.ties(state.model, state.knobs, over)
    state = replace(derive(bench, state), at_rest=False, bounds=bounds, ties=ties)
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
        here = positions(state.model, state.knobs)
        there = np.array([k.inside(x) for k, x in zip(state.knobs, here + step, strict=True)])
        model = turned(state.model, state.knobs, there)
        train = bench.fitted_z(model)
        jacobian = _broyden(state.jacobian, train - state.train, there - here)
        # of the loss itself: its squares, as weighted here, promise too little of what lies far off
        follows = state.train + state.jacobian @ (there - here)
        promised = state.merit - replace(state, model=model, train=follows).merit
        moved = replace(
            state, model=model, train=train, unseen=unseen(bench, model), jacobian=jacobian
        )
        if moved.merit < state.merit:
            gained = state.merit - moved.merit
            state = moved
            tell(state)
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


def weights(z: np.ndarray) -> np.ndarray:
    """Square roots of the weights that design least squares the pseudo-Huber loss."""
    return (1 + (z / SCALE) ** 2) ** -0.25


def _step(state: State, damping: float) -> tuple[np.ndarray, float]:
    """Damped step and the fall of the merit that it promises, within the bounds of the knobs.

    A level that lies beyond its bound, or that the step would take there, is taken to it.
    """
    w = weights(state.train)
    a = state.jacobian * w[:, None]
    b = state.train * w
    wanted: dict[int, float] = {}  # numbers that are pressed to their bounds, and these
    bounds, follows = state.bounds, state.train
    step = np.zeros(len(state.knobs))
    ties, off = tied(state)
    for n in range(3):
        out = [int(i) for i in np.flatnonzero(_beyond(follows, state.bounds)) if i not in wanted]
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
    return step, promised + _stiff(state.train, state.bounds) - _stiff(follows, state.bounds)


def tied(state: State) -> tuple[np.ndarray, np.ndarray]:
    """Rows and numbers of the ties, rows step + numbers their misfits after a step."""
    rows = np.zeros((len(state.ties), len(state.knobs)))
    for n, tie in enumerate(state.ties):
        rows[n, tie.at] = 1.0 / tie.error
    return rows, misfits(state.ties, positions(state.model, state.knobs))


def _pressing(state: State, wanted: dict[int, float]) -> tuple[np.ndarray, np.ndarray]:
    """Weighted rows and numbers, rows step + numbers = 0, that take numbers to what is wanted."""
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
    here = positions(state.model, state.knobs)
    step = np.zeros(len(here))
    for _ in range(3):  # a knob pushed against its bound is held there
        scaled = a[:, usable] / size[usable]
        normal = scaled.T @ scaled + damping * np.eye(int(usable.sum()))
        slope = scaled.T @ b
        if len(rest):
            pressing = rows[:, usable] / size[usable]
            normal, slope = normal + pressing.T @ pressing, slope + pressing.T @ rest
        step[:] = 0
        step[usable] = np.linalg.solve(normal, -slope) / size[usable]
        step = grid * np.rint(step / grid)
        step = np.clip(step, *longest(state.knobs, here))
        held = np.array(
            [
                (k.inside(x + s) == x and abs(s) > 0)
                for k, x, s in zip(state.knobs, here, step, strict=True)
            ]
        )
        if not (held & usable).any():
            break
        usable = usable & ~held
    return step


def longest(knobs: Sequence[Knob], here: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Longest step: a factor of 4 on a log scale, .15 eV, or a few times a linear value."""
    reach = np.array(
        [
            1.4 if k.log else 0.15 if k.part == "ea_ev" else 2 * abs(x) + 0.5
            for k, x in zip(knobs, here, strict=True)
        ]
    )
    return -reach, reach


def _broyden(jacobian: np.ndarray, change: np.ndarray, step: np.ndarray) -> np.ndarray:
    norm = float(step @ step)
    if norm == 0:
        return jacobian
    return jacobian + np.outer(change - jacobian @ step, step) / norm
