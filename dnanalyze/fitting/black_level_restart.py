"""Restart of a fit that ended far from the black level of the moments.

A black level that is lower by some DN, dark signals that are higher by as much, and a read noise
without the shot noise of that difference give nearly the same statistics. The chance in derivatives
of simulated frames hides the slope of the loss in this direction: on virtual sensors the loss
varies by 5 to 10 from one black level to the next, and the derivatives promise a minimum where it
has none.
"""

from __future__ import annotations

import math

from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.free_parameters import PEDESTAL, positions, with_values
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.level import NOISE
from dnanalyze.fitting.moments import moments
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.state import State, start
from dnanalyze.fitting.ties import GAIN
from dnanalyze.model.laws import value_at
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE

SIGNAL, READ = (BASE, "mu"), ("read_noise", "sigma")  # of a pixel


def at_black_level(problem: FitProblem, state: State, iterations: int) -> State:
    """The state, or one that is as good with the black level by the moments.

    Of two fits that the statistics do not tell apart, that stands which agrees with the levels: the
    loss of one simulated sensor scatters by about 1 per free parameter.

    Parameters
    ----------
    problem : FitProblem
    state : State
        At rest, its derivatives known: they tell how long a step must be.
    iterations : int
        Of the fit from there.

    Returns
    -------
    State
        ``state`` itself where a direct measurement binds the black level, or where the two differ
        by less than a level may (`fitting.level.NOISE`).
    """
    free = {i for i, k in enumerate(state.free) if k.effect == PEDESTAL}
    if len(free) != 1 or free & {t.at for t in state.ties}:
        return state
    noise = problem.train.values[problem.train.names == "temporal_noise_core"]
    sensor = problem.plan.captures.sensor
    measured = moments(Readings(problem.measured[0]), sensor.black_level).pedestal
    shift = measured - value_at(state.model.pedestal, state.model.reference)
    if not noise.size or abs(shift) <= NOISE * float(noise.min()):
        return state
    begun = start(problem, _shifted(state, shift), state.free, like=state)
    ended = minimise(problem, derive(problem, begun, anew=True), iterations)
    chance = len(state.free) * max(state.loss / len(state.train), 1.0)
    return ended if ended.merit < state.merit + chance else state


def _shifted(state: State, shift: float) -> NoiseModel:
    """The model with a higher black level, and the same levels and noise but for the charge."""
    model, where = state.model, positions(state.model, state.free)
    shot = model.get(GAIN[0])
    variance = 0.0 if shot is None else shift * shot.value(GAIN[1], model.reference)
    for i, parameter in enumerate(state.free):
        if parameter.effect == PEDESTAL:
            where[i] += shift
        elif (parameter.effect, parameter.parameter) == SIGNAL and not parameter.energy:
            where[i] = math.log(_less(math.exp(where[i]), shift))
        elif (parameter.effect, parameter.parameter) == READ and not parameter.energy:
            where[i] = math.log(_less(math.exp(2.0 * where[i]), -variance)) / 2.0
    return with_values(model, state.free, where)


def _less(amplitude: float, by: float) -> float:
    return max(amplitude - by, amplitude / 4.0)  # as far as in a step of a fit
