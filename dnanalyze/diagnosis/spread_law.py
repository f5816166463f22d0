"""Whether the relative standard deviation of the dark current changes with temperature.

The dark current of a pixel is the sum of diffusion from the neutral bulk, nearly the same in all
pixels, which grows as n_i^2 (about 1.1 eV), and generation in depleted silicon, which differs from
pixel to pixel and grows as n_i (about .6 eV). As a sensor warms, diffusion takes over and the
relative standard deviation falls.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from dnanalyze.comparator.predictive_check import FittedModel
from dnanalyze.diagnosis.gains import trial_of
from dnanalyze.diagnosis.selection import Trial, significant
from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.free_parameters import FreeParameter, free_parameters
from dnanalyze.fitting.from_part import FIT_STEPS, converge
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State, root_weights, with_derivatives_of
from dnanalyze.model.laws import ArrheniusLaw
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import BASE
from dnanalyze.significance import RARE

SPREAD = "delta"


def spread_law(null: FittedModel, wanted: float = math.inf) -> Trial | None:
    """The model with a slope of the spread over 1/kT, refitted, where that is significant.

    A score test comes first, at the level of one sensor in a thousand. A model with a law is not
    tested again. ``wanted``: loss that must come within reach; else the refit is given up.
    """
    problem, state = null.problem, null.state
    temperatures = {p.temperature_c for p, _ in problem.plan.settings} - {None}
    larger = with_law(state.model)
    if larger is None or len(temperatures) < 2:
        return None
    same = replace(state, model=larger, free=free_parameters(larger))  # it changes nothing yet
    begun = derive(problem, with_derivatives_of(same, state), only=_is_slope)
    if score(begun) < chi2.isf(RARE, 1):
        return None
    ended = minimise(problem, begun, FIT_STEPS, below=wanted)
    if ended.loss <= wanted:
        ended = converge(problem, ended, rounds=1, last=False)
    found = trial_of(null, BASE, ended)
    return found if significant(found) else None


def with_law(model: NoiseModel) -> NoiseModel | None:
    """The same model, its spread free to change; None where it has no constant spread."""
    light = model.get(BASE)
    celsius = model.reference.temperature_c
    spread = getattr(light, SPREAD, None)
    if light is None or celsius is None or not isinstance(spread, float):
        return None
    return model.with_effect(replace(light, **{SPREAD: ArrheniusLaw(spread, celsius, 0.0)}))


def score(state: State) -> float:
    """Squared standard score of the slope, the other parameters projected out (chi^2, 1 d.o.f.)."""
    at = np.array([_is_slope(k) for k in state.free])
    w = root_weights(state.train)
    a, b = np.nan_to_num(state.jacobian * w[:, None]), state.train * w
    free = np.linalg.qr(a[:, ~at & (np.linalg.norm(a, axis=0) > 1e-6)])[0]
    slope, rest = (x - free @ (free.T @ x) for x in (a[:, at].sum(axis=1), b))
    size = float(slope @ slope)
    return float(slope @ rest) ** 2 / size if size > 0 else 0.0


def in_words(problem: FitProblem, model: NoiseModel) -> str:
    """The law in a sentence."""
    light = model.get(BASE)
    assert light is not None
    celsius = sorted(t for p, _ in problem.plan.settings if (t := p.temperature_c) is not None)
    points = [
        replace(problem.plan.settings[0][0], temperature_c=t) for t in (celsius[0], celsius[-1])
    ]
    cold, warm = (math.sqrt(math.expm1(light.value(SPREAD, p) ** 2)) for p in points)
    verb = "falls" if warm < cold else "rises"
    return (
        f"the relative standard deviation of dark current {verb} from {cold:.3g} at "
        f"{celsius[0]:.4g} °C to {warm:.3g} at {celsius[-1]:.4g} °C"
    )


def _is_slope(parameter: FreeParameter) -> bool:
    return (parameter.effect, parameter.parameter, parameter.part) == (BASE, SPREAD, "ea_ev")
