"""A model beside the measurement: its misfits, and the loss that a fit lowers."""

from dataclasses import replace

import numpy as np
import pytest
import small_series as small
from hypothesis import given as drawn
from hypothesis import strategies as st

from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.free_parameters import free_parameters
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import SCALE, deviance, start, with_derivatives_of


def test_the_judged_half_is_simulated_once_and_only_where_it_is_asked_for(monkeypatch):
    asked, whole = [], FitProblem.held_out_z
    monkeypatch.setattr(
        FitProblem, "held_out_z", lambda self, model: asked.append(model) or whole(self, model)
    )
    problem, free = small.fit_problem_of(), free_parameters(small.model())
    ended = minimise(problem, start(problem, small.model(), free))
    assert not asked
    assert np.isfinite(ended.test).all()
    assert len(ended.test) == len(problem.test.keys)
    assert ended.test is ended.test
    assert asked == [ended.model]


def test_derivatives_of_another_model_are_taken_over_by_name():
    problem, model = small.fit_problem_of(), small.model()
    free = free_parameters(model)
    first = derive(problem, start(problem, model, free))
    other = with_derivatives_of(
        start(problem, model, free[::-1]),
        replace(first, free=free[:-1], jacobian=first.jacobian[:, :-1]),
    )
    np.testing.assert_array_equal(other.jacobian[:, 1:], first.jacobian[:, :-1][:, ::-1])
    assert np.isnan(other.jacobian[:, 0]).all()


def one(z: float) -> float:
    return float(deviance(np.array([z]))[0])


def test_the_deviance_is_a_square_below_its_scale_and_linear_beyond():
    np.testing.assert_allclose(deviance(np.array([0.1, -0.2])), [0.01, 0.04], rtol=1e-3)
    assert one(SCALE) == pytest.approx(2 * SCALE**2 * (np.sqrt(2) - 1))
    assert one(2e4) - one(1e4) == pytest.approx(2 * SCALE * 1e4, rel=1e-3)


@drawn(st.floats(0, 1e4), st.floats(0, 1e4))
def test_the_deviance_grows_with_the_difference(a, b):
    assert (one(a) <= one(b)) == (a <= b) or one(a) == one(b)
    assert one(a) == one(-a) <= a * a + 1e-9
