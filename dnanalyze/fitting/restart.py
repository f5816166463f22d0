"""Where a fit stays although the captures tell better: it begins again.

The derivative with respect to the logarithm of an amplitude goes as the amplitude itself. A fit
that once makes it small therefore stays there. Such an amplitude is raised until the statistics
show it, and begins again where the linear change from nothing to there lowers the loss most.

A black level that is lower by some DN, dark signals that are higher by as much and a read noise
without the shot noise of that are nearly the same to every statistic. The chance in the derivatives
of simulated frames hides the slope of this valley. A fit that has come to rest in it far from the
black level by the moments begins again there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from dnanalyze.fitting.changes import Changes
from dnanalyze.fitting.knobs import PEDESTAL, Knob, positions, settings_of, turned
from dnanalyze.fitting.least_squares import SMALLEST, State, derive, minimise, start, weights
from dnanalyze.fitting.level import NOISE
from dnanalyze.fitting.moments import moments
from dnanalyze.fitting.predictor import Bench
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.ties import GAIN
from dnanalyze.model.laws import value_at
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE

RISE = math.log(8.0)  # of an amplitude that is raised, each time
RISES = 6  # to 2.6e5 times
WORTH = (
    6.25  # fall of the loss below which a fit is not worth its simulations (see `selection.LEAST`)
)
SIGNAL, READ = (BASE, "mu"), ("read_noise", "sigma")  # of a pixel
FOURFOLD = 4.0  # by which an amplitude may fall in a step, as in a fit


def restarted(bench: Bench, state: State, iterations: int) -> State:
    """The state, or a better one with amplitudes that had been lost.

    Parameters
    ----------
    bench : Bench
    state : State
        At rest, its derivatives known.
    iterations : int
        Of the fit from there.
    """
    lost = _lost(bench, state) if state.knobs else []
    if not lost:
        return state
    there = _where_it_helps(bench, state, lost)
    if not there:
        return state
    where = positions(state.model, state.knobs)
    jacobian = state.jacobian.copy()
    for i, x in there.items():
        where[i] = x
        jacobian[:, i] = np.nan
    begun = start(bench, turned(state.model, state.knobs, where), state.knobs)
    ended = minimise(bench, replace(begun, jacobian=jacobian), iterations)
    return ended if ended.merit < state.merit - WORTH else state


def slid(bench: Bench, state: State, iterations: int) -> State:
    """The state, or one as good with the black level by the moments.

    Of two fits that the statistics do not tell apart, that stands which agrees with the levels: the
    luck of one simulated sensor bends the loss by about 1 a free parameter.

    Parameters
    ----------
    bench : Bench
    state : State
        At rest, its derivatives known.
    iterations : int
        Of the fit from there.
    """
    free = {i for i, k in enumerate(state.knobs) if k.effect == PEDESTAL}
    if len(free) != 1 or free & {t.at for t in state.ties}:
        return state
    law = value_at(state.model.pedestal, state.model.reference)
    noise = bench.train.values[bench.train.names == "temporal_noise_core"]
    sensor = bench.plan.captures.sensor
    black = moments(Readings(bench.measured[0]), sensor.black_level).pedestal
    if not noise.size or abs(black - law) <= NOISE * float(noise.min()):
        return state
    begun = start(bench, _of_black_level(state, black), state.knobs, like=state)
    ended = minimise(bench, derive(bench, begun, anew=True), 2 * iterations)
    chance = len(state.knobs) * max(state.loss / len(state.train), 1.0)
    return ended if ended.merit < state.merit + chance else state


def _of_black_level(state: State, black: float) -> NoiseModel:
    """The model with another black level, and the same levels and noise but for the charge."""
    model, where = state.model, positions(state.model, state.knobs)
    shift = black - value_at(model.pedestal, model.reference)
    shot = model.get(GAIN[0])
    variance = 0.0 if shot is None else shift * shot.value(GAIN[1], model.reference)
    for i, knob in enumerate(state.knobs):
        if knob.effect == PEDESTAL:
            where[i] = black
        elif (knob.effect, knob.parameter) == SIGNAL and not knob.energy:
            where[i] = math.log(_less(math.exp(where[i]), shift))
        elif (knob.effect, knob.parameter) == READ and not knob.energy:
            where[i] = math.log(_less(math.exp(2.0 * where[i]), -variance)) / 2.0
    return turned(model, state.knobs, where)


def _less(amplitude: float, by: float) -> float:
    return max(amplitude - by, amplitude / FOURFOLD)


def _lost(bench: Bench, state: State) -> list[int]:
    """Knobs that move an amplitude by its logarithm, without which the statistics are the same."""
    here = positions(state.model, state.knobs)
    groups = _groups(
        state, [i for i, k in enumerate(state.knobs) if _may_be_lost(bench, k, here[i])]
    )
    without = []
    for members in groups:
        lowered = here.copy()
        for i in members:
            lowered[i] = state.knobs[i].inside(here[i] - RISE)
        without.append(turned(state.model, state.knobs, lowered))
    found = []
    if not groups:
        return []
    changes = Changes.of(bench, state.model, state.model.placing)
    for members, change in zip(groups, changes.by(without), strict=True):
        found += [i for i in members if np.linalg.norm(_own(bench, state, i, change)) < SMALLEST]
    return found


def _may_be_lost(bench: Bench, knob: Knob, position: float) -> bool:
    """Whether a knob is the logarithm of a level, a noise or a gain small enough to be lost.

    A level or a noise above that of the quietest pixels shows; of a gain nothing is known.
    """
    if not knob.logarithmic:
        return False
    noise = bench.train.values[bench.train.names == "temporal_noise_core"]
    if knob.unit in ("DN", "ln DN"):
        return noise.size > 0 and math.exp(position) < float(noise.min())
    return knob.unit == "DN/e-"


def _groups(state: State, members: Sequence[int]) -> list[list[int]]:
    """Knobs that one simulation can move together: rows of a table move other settings."""
    groups: dict[str, list[int]] = {}
    for i in members:
        groups.setdefault(state.knobs[i].group, []).append(i)
    return list(groups.values())


def _own(bench: Bench, state: State, at: int, change: np.ndarray) -> np.ndarray:
    """A change at the settings that a knob moves."""
    mask = settings_of(state.knobs[at], state.model, bench.plan.settings)
    return np.where(mask[bench.train.setting], change, 0.0)


def _where_it_helps(bench: Bench, state: State, lost: Sequence[int]) -> dict[int, float]:
    """Positions of the knobs at which the loss is expected to fall; the others are left out."""
    here = positions(state.model, state.knobs)
    found: dict[int, float] = {}
    for members in _groups(state, lost):
        for n in range(1, RISES + 1):
            raised = here.copy()
            for i in members:
                raised[i] = state.knobs[i].inside(here[i] + n * RISE)
            moved = bench.fitted_z(turned(state.model, state.knobs, raised)) - state.train
            seen = []
            for i in members:
                change = _own(bench, state, i, moved)
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

    The knobs that are not lost follow linearly.
    """
    w = weights(state.train)
    others = np.delete(np.nan_to_num(state.jacobian), list(lost), axis=1)
    others = others[:, np.linalg.norm(others, axis=0) > 1e-6] * w[:, None]
    free = np.linalg.qr(others)[0] if others.size else np.zeros((w.size, 0))
    step, rest = (x - free @ (free.T @ x) for x in (change * w, state.train * w))
    size = float(step @ step)
    share = -float(step @ rest) / size if size > 0.0 else 0.0
    return min(share, 1.0) if share > 0.0 and share**2 * size > WORTH else 0.0
