"""Amplitudes that a fit has lost are found again."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import small_series as small

from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.design import design
from dnanalyze.fitting.free_parameters import free_parameters, positions
from dnanalyze.fitting.from_part import converge
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.restart import restarted
from dnanalyze.fitting.state import start
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.simulate import simulate

POINTS = [(OperatingPoint(25.0, t), 4) for t in (0.1, 0.4, 1.6)]


def truth(seed: int = 9):
    """About 20 to 320 DN of dark signal."""
    return replace(small.model(convolved_lognormal={"mu": 3.0}), seed=seed)


@pytest.fixture(scope="module")
def problem():
    return fit_problem(design(simulate(truth(), (128, 128), POINTS)))


def with_gain(gain: float):
    model = truth(seed=4)
    shot = model.get("dark_shot_noise")
    return model.with_effect(replace(shot, dn_per_e=gain))


@pytest.mark.long
@pytest.mark.parametrize("gain", [1.1e-4, pytest.param(1e-3, marks=pytest.mark.slow), 0.05])
def test_a_gain_of_any_size_ends_where_the_true_one_does(problem, gain):
    """The truth is .5 DN/e-; at 1.1e-4 no statistic moves with the logarithm of the gain."""
    model = with_gain(gain)
    ended = converge(problem, start(problem, model))
    found = ended.model.get("dark_shot_noise").dn_per_e
    # photon transfer over 320 DN: sqrt(2 / (3 * 128^2)) of either sensor, and the baseline's share
    assert found == pytest.approx(0.5, rel=0.1)


def test_a_far_step_of_a_logarithm_is_that_of_the_amplitude(problem):
    """What is proportional to an amplitude grows by exp(step) - 1 times what it is."""
    model = with_gain(1.1e-4)
    free = [k for k in free_parameters(model) if k.name == "dark_shot_noise.dn_per_e"]
    (slope,) = derive(problem, start(problem, model, free)).jacobian.T
    whole = problem.train.z(problem.fitted_coordinates(with_gain(0.05))) - problem.fitted_z(model)
    # of the variance at .05 DN/e-, 1.1e-4 gives 1 / 450: chance of codes apart
    assert np.linalg.norm(slope) < 0.1 * np.linalg.norm(whole)
    parameter = free[0]
    assert parameter.change(0.0, 3.0) == pytest.approx(math.expm1(3.0))
    assert parameter.change(0.0, 0.5) == 0.5
    linear = free_parameters(model)[0]
    assert not linear.logarithmic
    assert linear.change(1.0, 9.0) == 8.0


def test_nothing_is_lost_at_the_truth(problem):
    model = truth(seed=4)
    state = derive(problem, start(problem, model))
    again = restarted(problem, state, 3)
    np.testing.assert_allclose(
        positions(again.model, again.free), positions(state.model, state.free)
    )
