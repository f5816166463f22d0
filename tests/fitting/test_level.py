"""The mean dark level: what a model may be off in it, and that a fit does not give it up."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import small_series as small

from dnanalyze.comparator.predictive_check import FittedModel
from dnanalyze.fitting.free_parameters import free_parameters, positions
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.level import DarkSignals, allowed, level
from dnanalyze.fitting.state import start
from dnanalyze.fitting.vectors import Key, Target
from dnanalyze.loaders.captures import OperatingPoint

POINTS = [OperatingPoint(-10.0, 300.0), OperatingPoint(-5.0, 300.0)]


def half(floors):
    """A level and a median at either point."""
    names = ("mean", "median")
    keys = tuple(Key(s, "", n) for s in range(2) for n in names)
    ones = np.ones(4)
    return Target(keys, 100 * ones, 100 * ones, np.repeat(floors, 2), np.full(4, "level"))


def signals_of(signal, noise=0.0):
    """Of mean and median at either point."""
    return DarkSignals(np.repeat([0.0, signal], 2), np.full(4, noise))


@pytest.mark.parametrize(
    ("off", "signal", "noise", "kept", "share"),
    [
        (2.9, 0.0, 0.0, True, None),  # within 3 standard errors
        (3.1, 0.0, 0.0, False, None),
        (3.1, 400.0, 0.0, True, 3.1 / 400),  # within 1 % of the dark signal
        (4.1, 400.0, 0.0, False, 4.1 / 400),
        (3.9, 0.0, 80.0, True, None),  # within 5 % of the temporal noise
        (4.1, 0.0, 80.0, False, None),
    ],
)
@pytest.mark.parametrize("which", ["mean", "median"])
def test_either_level_may_be_off_by_the_largest_of_three(off, signal, noise, kept, share, which):
    halves = half(np.array([50.0, 1.0])), half(np.array([50.0, 1.0]))
    z = np.array([0.0, 0.0, -off, 0.0] if which == "mean" else [0.0, 0.0, 0.0, -off])
    found = level(POINTS, halves, (z, z), signals_of(signal, noise))
    assert found.kept == kept
    assert found.statistic == which
    assert found.point == POINTS[1]
    assert found.difference_dn == pytest.approx(-off)
    assert found.standard_errors == pytest.approx(off)
    assert found.relative is None if share is None else found.relative == pytest.approx(-share)


def test_the_level_is_that_of_both_halves_together():
    """What one half has more and the other less is shading, not level."""
    halves = half(np.ones(2)), half(np.ones(2))
    z = np.array([0.0, 0.0, 5.0, 0.0])
    assert level(POINTS, halves, (z, -z), signals_of(0.0)).kept
    assert not level(POINTS, halves, (z, z), signals_of(0.0)).kept


def test_a_model_of_another_level_is_not_adequate_whatever_its_error():
    problem = small.fit_problem_of()
    right = start(problem, small.model(), [])
    mean = [np.where(half.names == "mean", 0.2, 0.0) for half in (problem.train, problem.test)]
    for size, kept in ((1.0, True), (40.0, False)):
        train, test = (size * z for z in mean)
        found = FittedModel(problem, replace(right, train=train, unseen=lambda test=test: test))
        assert found.adequate == kept
        assert found.left == ([] if kept else ["mean"])


def test_the_signal_is_above_the_measured_black_level():
    """A fit may miss the median by half of 1 % of it, or by 2 standard deviations at no signal."""
    problem = small.fit_problem_of()
    at = problem.train.names == "median"
    assert np.isinf(problem.train.bounds()[~at]).all()
    values, floors = problem.train.values[at], problem.train.reproducibility_sd[at]
    noise = problem.train.values[problem.train.names == "temporal_noise_core"]
    tolerance = np.maximum(0.005 * (values - 64.0), 0.025 * noise)
    np.testing.assert_allclose(
        problem.train.bounds()[at], np.maximum(2.0, tolerance / floors), rtol=0.05
    )


@pytest.mark.parametrize(("shift", "wanted"), [(0.0, 2.0), (30.0, 60.0)])
def test_a_level_beyond_the_laws_may_be_off_by_twice_that(shift, wanted):
    """Four exposures of 10 DN/s above 100 DN, errors of 1 DN; one level is off."""
    points = [OperatingPoint(20.0, float(t)) for t in range(6)]
    values = np.array([100.0, 110.0, 120.0, 130.0 + shift, 140.0, 150.0])
    keys = tuple(Key(s, "", "median") for s in range(6))
    problem = Target(keys, values, values, np.ones(6), np.full(6, "level"))
    problem = replace(
        problem, allowed=allowed(problem, DarkSignals(np.zeros(6), np.zeros(6)), points)
    )
    assert problem.bounds()[3] == pytest.approx(wanted, rel=0.05)
    assert problem.bounds()[[0, 1, 2, 4, 5]] == pytest.approx(2.0, rel=0.2)


def test_levels_of_colour_planes_that_are_apart_may_be_off_by_twice_that():
    """Errors of 1 DN; one law of black level and dark signal reaches one level."""
    keys = tuple(Key(0, plane, "median") for plane in ("R", "Gr", "Gb", "B"))
    values = np.array([99.0, 101.0, 110.0, 94.0])  # 100 in the median
    problem = Target(keys, values, values, np.ones(4), np.full(4, "level"))
    found = allowed(problem, DarkSignals(np.zeros(4), np.zeros(4)), [OperatingPoint(20.0, 0.1)])
    assert replace(problem, allowed=found).bounds() == pytest.approx([2.0, 2.0, 20.0, 12.0])


@pytest.mark.parametrize(("overdispersion", "bound"), [(0.5, 2.0), (1.0, 2.0), (16.0, 0.5)])
def test_what_is_wrong_with_a_model_narrows_the_bounds_of_its_levels(overdispersion, bound):
    """By its root, as it does for all that binds a fit; what a level may be off anyway stays."""
    keys = tuple(Key(s, "", "median") for s in range(2))
    problem = Target(keys, np.zeros(2), np.zeros(2), np.full(2, 0.1), np.full(2, "level"))
    problem = replace(problem, allowed=np.array([0.0, 0.3]))
    assert problem.bounds(overdispersion) == pytest.approx([bound, 3.0])


@pytest.mark.parametrize("bound", [np.inf, 4.0])
def test_a_level_is_not_given_up_for_many_statistics_that_lie_far_off(bound):
    """All others want the parameter elsewhere; the loss of one number that is far off is small."""
    model = small.model()
    free = free_parameters(model)[:1]
    here = positions(model, free)[0]
    bounds = np.full(21, np.inf)
    bounds[0] = bound

    def z(moved):
        x = positions(moved, free)[0] - here
        return np.concatenate([[30.0 * x], np.full(20, 60.0 * (x - 1.0))])

    problem = SimpleNamespace(bounds=lambda _: bounds, weight=1.0)
    straight = SimpleNamespace(fitted_z=z, held_out_z=z, train=problem, ties=lambda *_: ())
    slope = np.concatenate([[30.0], np.full(20, 60.0)])[:, None]
    ended = minimise(straight, replace(start(straight, model, free), jacobian=slope), 12)
    if np.isinf(bound):
        assert ended.train[0] == pytest.approx(30.0, rel=0.05)
    else:
        assert 0.8 * bound < ended.train[0] <= 1.15 * bound


def test_bounds_that_are_kept_change_no_step():
    model = small.model()
    problem = small.fit_problem_of()
    unbound = replace(problem, train=replace(problem.train, allowed=None))
    free = free_parameters(model)[:2]
    wide = replace(
        problem, train=replace(problem.train, allowed=1e9 * problem.train.reproducibility_sd)
    )
    ended = [minimise(b, start(b, model, free), 1) for b in (wide, unbound)]
    assert ended[0].model == ended[1].model
    assert ended[0].merit == ended[1].loss
