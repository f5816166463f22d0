"""Derivatives of what a model predicts, by one simulation a group of knobs.

What is everywhere in the field moves a part of it as it moves the whole. Its knobs are turned on
the part, at about a third of the time; those of what has a place, or few pixels, on the whole.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from dnanalyze.fitting.knobs import PEDESTAL, Knob, positions, settings_of, turned
from dnanalyze.fitting.predictor import Bench
from dnanalyze.fitting.state import State, carried, evened
from dnanalyze.loaders.thermometer import tells_slope
from dnanalyze.model.effect import Placing
from dnanalyze.model.noise_model import NoiseModel

# Useful size of a derivative step, floors (Euclidean). Pixels that cross a code's edge jump,
# and the statistics with them, by some floors however short the step: less would be lost in it.
SMALLEST, LARGEST = 12.0, 400.0
SEVERAL = 3  # derivatives beyond which it pays to begin from half of the field
GROWTH = 8.0  # of a step that shows too little, each time; twice at most


def derive(
    bench: Bench,
    state: State,
    only: Callable[[Knob], bool] = lambda _: True,
    smallest: float = SMALLEST,
    anew: bool = False,
) -> State:
    """Take the derivatives that are not known yet, one simulation a group of knobs.

    A first step that moves the numbers by less than ``smallest`` floors is taken again, longer.
    ``anew``: also those that are known, which then tell how long a step must be.
    """
    wanted: dict[str, list[int]] = {}
    for i, knob in enumerate(state.knobs):
        if (anew or np.isnan(state.jacobian[:, i]).any()) and only(knob):
            wanted.setdefault(knob.group, []).append(i)
    jacobian = state.jacobian.copy()
    near: list[list[int]] = []
    far: list[list[int]] = []
    for members in wanted.values():
        knob = state.knobs[members[0]]
        if not _told(bench, state.model, knob):
            jacobian[:, members] = 0.0
        elif bench.part is not None and placing_of(state.model, knob) is Placing.EVERYWHERE:
            near.append(members)
        else:
            far.append(members)
    if near and bench.part is not None:
        there = carried(state, bench, bench.part)
        seen = _differences(bench.part, there, near, smallest)
        columns = bench.part.train.derivatives_of(bench.train, np.stack(list(seen.values()), 1))
        jacobian[:, list(seen)] = columns
    alone, begun = evened(bench, state) if len(far) > SEVERAL else (bench, state)
    for i, column in _differences(alone, begun, far, smallest).items():
        jacobian[:, i] = column
    return replace(state, jacobian=jacobian)


def placing_of(model: NoiseModel, knob: Knob) -> Placing:
    """Where in the field a knob acts: the black level does everywhere."""
    effect = model.get(knob.effect)
    return Placing.EVERYWHERE if effect is None else effect.placing


def _told(bench: Bench, model: NoiseModel, knob: Knob) -> bool:
    """Whether the fitted half tells of a knob.

    Of what lies in the judged half alone it tells nothing, nor do temperatures too near each other
    of an activation energy.
    """
    effect = model.get(knob.effect)
    if knob.energy and not tells_slope(p.temperature_c for p, _ in bench.plan.settings):
        return False
    return effect is None or effect.lies_in(bench.plan.windows[0])


def _differences(
    bench: Bench, state: State, groups: list[list[int]], smallest: float
) -> dict[int, np.ndarray]:
    """Columns of groups of knobs, by one-sided steps that are sized to be seen but not large."""
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
