"""A spread of dark current that changes with temperature, on sensors made by NumPy alone."""

from dataclasses import replace

import numpy as np
import pytest

from dnanalyze.comparator.predictive_check import FittedModel
from dnanalyze.diagnosis.spread_law import in_words, spread_law, with_law
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model
from dnanalyze.fitting.from_part import converge
from dnanalyze.fitting.problem import FitProblem, fit_problem
from dnanalyze.fitting.state import State, start
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting
from dnanalyze.model.laws import ArrheniusLaw
from dnanalyze.model.registry import BASE
from dnanalyze.model.simulate import simulate_frames
from dnanalyze.thermal import BOLTZMANN_EV

SHAPE = (96, 96)
COLD, MIDDLE, WARM = -10.0, -5.0, 0.0
KELVIN = 273.15


def inverse(celsius):
    """1/kT from that at `MIDDLE`, 1/eV."""
    return (1 / (celsius + KELVIN) - 1 / (MIDDLE + KELVIN)) / BOLTZMANN_EV


def sensor(slope, seed=1):
    """Log-normal dark current of 200 e- at -5 C; the spread .2 exp(-slope / kT), 2 e- per DN."""
    rng = np.random.default_rng(seed)
    z, offset = rng.standard_normal(SHAPE), 2.0 * rng.standard_normal(SHAPE)
    settings = []
    for t in (COLD, MIDDLE, WARM):
        spread = 0.2 * np.exp(-slope * inverse(t))
        charge = 200.0 * np.exp(-0.8 * inverse(t)) * np.exp(spread * z - spread**2 / 2)
        point = OperatingPoint(t, 100.0, 1.0)
        frames = []
        for n in range(4):
            e = rng.poisson(charge) + offset + 6.0 * rng.standard_normal(SHAPE)
            codes = np.rint(0.5 * e + 500.0).astype(np.uint16)
            frames.append(
                Frame(f"{t}/{n}", point, lambda w, y=codes: y if w is None else y[w.slices])
            )
        settings.append(Setting(point, tuple(frames)))
    return CaptureSet("made", Sensor(SHAPE), tuple(settings))


def ordinary(slope) -> tuple[FitProblem, State]:
    problem = fit_problem(design(sensor(slope)))
    model = baseline_model(problem)
    return problem, converge(problem, start(problem, model), rounds=2)


@pytest.mark.long
def test_a_spread_that_falls_is_found_and_the_level_is_kept():
    problem, state = ordinary(-0.3)
    found = spread_law(FittedModel(problem, state))
    assert found is not None
    assert found.error < FittedModel(problem, state).error - 0.2
    ended = converge(problem, found.state)
    law = ended.model.get(BASE).delta
    # 1.5 % of either spread on 96 x 48 pixels, over 1.6 / eV from end to end, and as much again of
    # a kernel weight that is not held at 0: its standard error of .01 is one of .08 in the variance
    assert law.ea_ev == pytest.approx(-0.3, abs=0.05)
    assert law.value == pytest.approx(0.2, rel=0.1)
    assert problem.level(ended.train, ended.test).kept
    assert "falls from 0.2" in in_words(problem, ended.model)


def test_a_constant_spread_stays_one_number():
    problem, state = ordinary(0.0)
    assert spread_law(FittedModel(problem, state)) is None


def test_a_law_is_asked_for_once_and_of_several_temperatures():
    problem, state = ordinary(-0.3)
    lawful = replace(state, model=with_law(state.model))
    assert spread_law(FittedModel(problem, lawful)) is None
    assert spread_law(FittedModel(problem.only([1]), state)) is None


def test_the_law_begins_as_the_same_model_to_the_last_bit():
    problem, state = ordinary(0.0)
    law = with_law(state.model).get(BASE).delta
    assert isinstance(law, ArrheniusLaw)
    assert law.ea_ev == 0.0
    for point in (s.point for s in problem.plan.captures.settings):
        a, b = (
            list(simulate_frames(m, SHAPE, point, [0, 1]))
            for m in (state.model, with_law(state.model))
        )
        np.testing.assert_array_equal(a, b)
