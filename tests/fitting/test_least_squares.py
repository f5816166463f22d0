"""Steps of a fit."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import small_series as small

from dnanalyze.fitting.free_parameters import free_parameters, positions
from dnanalyze.fitting.least_squares import HOPE, minimise, within_reach
from dnanalyze.fitting.state import State, start
from dnanalyze.fitting.vectors import Key, Target


@pytest.mark.parametrize(
    ("factor", "far", "true"), [(1, 0.5, True), (1 / 1.01, 50, True), (3, 0.5, False)]
)
def test_a_step_tells_whether_its_derivatives_are_true(factor, far, true):
    """Three times too large they promise all, of a line, and bring five ninths.

    Of what lies far off, a step brings twice what the weighted squares promise (here all at once,
    since what the damping takes off the step the slope adds).
    """
    model = small.model()
    free = free_parameters(model)[:1]
    here = positions(model, free)
    slope = np.full((500, 1), 2.0 * far)

    def z(moved):
        return far - slope[:, 0] * (positions(moved, free) - here)

    problem = SimpleNamespace(bounds=lambda _: None, weight=1.0)
    straight = SimpleNamespace(fitted_z=z, held_out_z=z, train=problem, ties=lambda *_: ())
    begun = State(model, free, z(model), lambda: z(model), -factor * slope, not true)
    ended = minimise(straight, begun, 5, tolerance=0.992 if far < 1 else 0.01)
    assert ended.loss < 0.5 * begun.loss
    assert ended.at_rest == true
    assert not start(straight, ended.model, free, like=ended).at_rest
    assert not minimise(straight, replace(begun, at_rest=True), below=-1e9).at_rest


def test_the_last_bits_of_linear_algebra_do_not_choose_the_path(monkeypatch):
    """Libraries that solve the same equations differ by some 1e-13; the models must not."""
    problem, begun = small.fit_problem_of(), replace(small.model(), pedestal=60.0)
    exact, rng = np.linalg.solve, np.random.default_rng(4)
    ended = minimise(problem, start(problem, begun), iterations=3)
    monkeypatch.setattr(
        np.linalg, "solve", lambda a, b: exact(a, b) * (1 + 1e-13 * rng.normal(size=b.shape))
    )
    again = minimise(problem, start(problem, begun), iterations=3)
    assert again.model == ended.model != begun
    np.testing.assert_array_equal(again.train, ended.train)


@pytest.mark.parametrize(("share", "reached"), [(0.5, False), (2.0, True)])
def test_a_loss_is_within_reach_up_to_some_times_what_a_step_promises(share, reached):
    model = small.model()
    free = free_parameters(model)[:2]
    slope = np.zeros((500, 2))
    slope[:50, 0] = 1.0  # moves a tenth of the numbers
    slope[:, 1] = np.nan  # not known: it promises nothing
    state = State(model, free, np.full(500, 0.1), lambda: np.zeros(1), slope)
    promised = 50 * 0.1**2
    assert within_reach(state, state.loss - HOPE * promised / share) == reached


def test_families_count_equally_in_a_fit():
    """Nine numbers of one family want a parameter at 1, one of another family wants it at 0."""
    model = small.model()
    free = free_parameters(model)[:1]
    here = positions(model, free)[0]
    families = np.array(["level", *["spectrum"] * 9])
    target = Target(tuple(Key(0, "", f"n{i}") for i in range(10)), *np.zeros((3, 10)), families)
    assert target.weight == pytest.approx([5.0, *[5.0 / 9.0] * 9])

    def z(moved):
        return (positions(moved, free)[0] - here) - (families == "spectrum")

    problem = SimpleNamespace(bounds=lambda _: None, weight=target.weight)
    straight = SimpleNamespace(fitted_z=z, held_out_z=z, train=problem, ties=lambda *_: ())
    begun = replace(start(straight, model, free), jacobian=np.ones((10, 1)))
    ended = minimise(straight, begun, 12, tolerance=1e-4)
    assert ended.train[0] == pytest.approx(0.5, abs=0.02)
    assert ended.loss == pytest.approx(10 * 0.5**2, rel=0.01)  # of squares, nearly
