"""Fits that begin on a part of the field.

What every part shows alike can be fitted to a quarter of the field, in less than half of the time.
The whole field then begins near the end, with derivatives nearly as good as those of another
simulated sensor.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from dnanalyze.fitting.black_level_restart import at_black_level
from dnanalyze.fitting.changes import part_for
from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.restart import restarted
from dnanalyze.fitting.state import State, carried, start
from dnanalyze.fitting.time_limit import TimeLimit, TimeUp
from dnanalyze.fitting.yardstick import by_design, expressed
from dnanalyze.model.noise_model import NoiseModel

FIT_STEPS = 6  # of a fit between two computations of the derivatives
# Fall of the loss in a round with new derivatives, per overdispersion, below which no parameter
# moves by more than about its standard error: then the fit has ended.
SETTLED = 2.0


def fitted(
    problem: FitProblem, model: NoiseModel, fit: Callable[[FitProblem, State], State] = minimise
) -> State:
    """A model fitted to the part first, where it may be, by the yardstick of its initial values.

    Parameters
    ----------
    problem : FitProblem
    model : NoiseModel
        Where to begin.
    fit : callable
        What is done on either field.
    """
    part = part_for(problem, model)
    near = by_design(part or problem, model)
    state = fit(near, start(near, model))
    if part is None:
        return expressed(state, near, problem)
    there = problem.scaled_as(near)
    return expressed(fit(there, carried(state, near, there)), there, problem)


def fitted_in_time(problem: FitProblem, model: NoiseModel) -> State:
    """`fitted`, or where it stood when the time was up."""
    so_far: list[State] = []
    try:
        return fitted(problem, model, partial(minimise, on_state=so_far.append))
    except TimeUp:
        best = so_far[-1].model if so_far else model
        return start(problem.within(TimeLimit()), best)


def converge(
    problem: FitProblem,
    state: State,
    rounds: int = 3,
    iterations: int = FIT_STEPS,
    on_state: Callable[[State], None] = lambda _: None,
    hopeless: float = math.inf,
    settled: float = SETTLED,
    last: bool = True,
) -> State:
    """Minimise with new derivatives in each round, until a round gains too little.

    Broyden's derivatives are good enough to get near; the last steps want true ones. In a valley,
    such as that of black level, dark signal and read noise, they seem to promise nothing more while
    new ones do; so a fit has ended when a round with new ones gains nothing. ``hopeless``: loss a
    number from which true derivatives are not worth their simulations. ``settled``: gain of a
    round, in units of the overdispersion, below which the fit has ended. An amplitude that was lost
    on the way begins again at the end, and so does a fit far from the black level by the moments,
    where it is the ``last``: a search moves the black level with every effect.
    """

    def ended(begun: State) -> State:
        there = _in_rounds(problem, begun, rounds, iterations, on_state, hopeless, settled)
        found = restarted(problem, there, iterations)
        return there if found is there else ended(found)

    state = ended(state)
    if not last:
        return state
    # in as many steps again: of a sensor it took twelve from there to the loss of the other fit
    found = at_black_level(problem, state, 2 * iterations)
    return state if found is state else ended(found)


def _in_rounds(
    problem: FitProblem,
    state: State,
    rounds: int,
    iterations: int,
    on_state: Callable[[State], None],
    hopeless: float,
    settled: float,
) -> State:
    for n in range(2 * rounds):
        before = state.merit
        begun = derive(problem, state, anew=True) if n else state
        state = minimise(problem, begun, iterations, 0.5 / len(state.train), on_state)
        least = settled * max(1.0, before / len(state.train))
        if (n > 0 and before - state.merit < least) or state.loss > hopeless * len(state.train):
            break
    return state
