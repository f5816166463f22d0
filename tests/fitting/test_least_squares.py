"""Derivatives and the steps they are taken with."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import small_series as small
from hypothesis import given as drawn
from hypothesis import strategies as st

from dnanalyze.fitting import least_squares
from dnanalyze.fitting.derivatives import SEVERAL, derive
from dnanalyze.fitting.knobs import knobs_of, positions
from dnanalyze.fitting.least_squares import minimise
from dnanalyze.fitting.predictor import Bench
from dnanalyze.fitting.state import SCALE, deviance, given, start, with_derivatives_of
from dnanalyze.fitting.ties import Direct


def test_known_derivatives_size_the_steps_of_new_ones(monkeypatch):
    held, tried = small.bench_of(), []
    whole = Bench.several

    def counted(self, models):
        tried.extend(models)
        return whole(self, models)

    monkeypatch.setattr(Bench, "several", counted)
    begun = start(held, small.model(), knobs_of(small.model()))
    first = derive(held, begun)
    groups, once = len({k.group for k in begun.knobs}), len(tried)
    assert once > groups  # some first steps were too short, or too long
    tried.clear()
    again = derive(held, first, anew=True)
    assert groups <= len(tried) < once
    old, new = (np.linalg.norm(s.jacobian, axis=0) for s in (first, again))
    assert np.all(
        np.sum(first.jacobian * again.jacobian, axis=0) > 0.6 * old * new
    )  # a step shows a dozen floors
    tried.clear()
    assert derive(held, first) is not None
    assert not tried


@pytest.mark.parametrize("extra", [None, "rts", "row_fpn"])
def test_many_derivatives_are_taken_on_half_of_the_field_where_that_tells_them(extra, monkeypatch):
    """The level and the shading but lack what is chance in the other half."""
    held, model = small.bench_of(), small.model()
    if extra is not None:
        model = model.with_effect(small.KNOWN[extra]())
    begun, benches = start(held, model, knobs_of(model)), []
    whole = Bench.several

    def seen(self, models):
        benches.append((self.even, len(models)))
        return whole(self, models)

    monkeypatch.setattr(Bench, "several", seen)
    monkeypatch.setattr(least_squares, "_rescaled", lambda size, _: np.ones_like(size))
    together = derive(held, begun).jacobian
    assert {even for even, count in benches if count > SEVERAL} == {extra != "row_fpn"}
    benches.clear()
    groups = {k.group for k in begun.knobs}
    alone = [derive(held, begun, only=lambda k, g=g: k.group == g).jacobian for g in groups]
    assert not any(even for even, _ in benches)
    one_by_one = np.nanmean(alone, axis=0)
    shaded = np.array(["shading" in n or n in ("mean", "median") for n in held.train.names])
    np.testing.assert_allclose(together[~shaded], one_by_one[~shaded], rtol=1e-9, atol=1e-9)
    apart = np.linalg.norm(together - one_by_one, axis=0)
    assert np.all(apart < 0.3 * np.linalg.norm(one_by_one, axis=0))


def test_the_judged_half_is_simulated_once_and_only_where_it_is_asked_for(monkeypatch):
    asked, whole = [], Bench.judged_z
    monkeypatch.setattr(
        Bench, "judged_z", lambda self, model: asked.append(model) or whole(self, model)
    )
    held, knobs = small.bench_of(), knobs_of(small.model())
    ended = minimise(held, start(held, small.model(), knobs))
    assert not asked
    assert np.isfinite(ended.test).all()
    assert len(ended.test) == len(held.test.keys)
    assert ended.test is ended.test
    assert asked == [ended.model]


@pytest.mark.parametrize(
    ("factor", "far", "true"), [(1, 0.5, True), (1 / 1.01, 50, True), (3, 0.5, False)]
)
def test_a_step_tells_whether_its_derivatives_are_true(factor, far, true):
    """Three times too large they promise all, of a line, and bring five ninths.

    Of what lies far off, a step brings twice what the weighted squares promise (here all at once,
    since what the damping takes off the step the slope adds).
    """
    model = small.model()
    knobs = knobs_of(model)[:1]
    here = positions(model, knobs)
    slope = np.full((500, 1), 2.0 * far)

    def z(moved):
        return far - slope[:, 0] * (positions(moved, knobs) - here)

    held = SimpleNamespace(bounds=lambda _: None)
    straight = SimpleNamespace(fitted_z=z, judged_z=z, train=held, direct=Direct())
    begun = least_squares.State(model, knobs, z(model), given(z(model)), -factor * slope, not true)
    ended = minimise(straight, begun, 5, tolerance=0.992 if far < 1 else 0.01)
    assert ended.loss < 0.5 * begun.loss
    assert ended.at_rest == true
    assert not start(straight, ended.model, knobs, like=ended).at_rest
    assert not minimise(straight, replace(begun, at_rest=True), below=-1e9).at_rest


def test_derivatives_of_another_model_are_taken_over_by_name():
    held, model = small.bench_of(), small.model()
    knobs = knobs_of(model)
    first = derive(held, start(held, model, knobs))
    other = with_derivatives_of(
        start(held, model, knobs[::-1]),
        replace(first, knobs=knobs[:-1], jacobian=first.jacobian[:, :-1]),
    )
    np.testing.assert_array_equal(other.jacobian[:, 1:], first.jacobian[:, :-1][:, ::-1])
    assert np.isnan(other.jacobian[:, 0]).all()


def test_the_last_bits_of_linear_algebra_do_not_choose_the_path(monkeypatch):
    """Libraries that solve the same equations differ by some 1e-13; the models must not."""
    held, begun = small.bench_of(), replace(small.model(), pedestal=60.0)
    exact, rng = np.linalg.solve, np.random.default_rng(4)
    ended = minimise(held, start(held, begun, knobs_of(begun)), iterations=3)
    monkeypatch.setattr(
        np.linalg, "solve", lambda a, b: exact(a, b) * (1 + 1e-13 * rng.normal(size=b.shape))
    )
    again = minimise(held, start(held, begun, knobs_of(begun)), iterations=3)
    assert again.model == ended.model != begun
    np.testing.assert_array_equal(again.train, ended.train)


@pytest.mark.parametrize(("span", "held"), [(1.6, True), (20.0, False)])
def test_an_energy_is_held_where_the_temperatures_tell_no_slope(span, held):
    bench = small.bench_of()
    settings = tuple(
        replace(s, point=replace(s.point, temperature_c=25.0 + span * (n > 0)))
        for n, s in enumerate(bench.plan.captures.settings)
    )
    captures = replace(bench.plan.captures, settings=settings)
    bench = replace(bench, plan=replace(bench.plan, captures=captures))
    model = small.model().with_effect(small.KNOWN["hot_pixels"](fraction=0.05, scale=200.0))
    knobs = [k for k in knobs_of(model) if k.effect == "hot_pixels" and k.parameter == "ea_ev"]
    found = derive(bench, start(bench, model, knobs))
    assert (np.linalg.norm(found.jacobian) == 0) == held


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
