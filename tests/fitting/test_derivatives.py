"""Derivatives, and the steps that they are taken with."""

from dataclasses import replace

import numpy as np
import pytest
import small_series as small

from dnanalyze.fitting import derivatives
from dnanalyze.fitting.derivatives import SEVERAL, derive
from dnanalyze.fitting.free_parameters import free_parameters
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import start


def test_known_derivatives_size_the_steps_of_new_ones(monkeypatch):
    problem, tried = small.fit_problem_of(), []
    whole = FitProblem.several

    def counted(self, models):
        tried.extend(models)
        return whole(self, models)

    monkeypatch.setattr(FitProblem, "several", counted)
    begun = start(problem, small.model())
    first = derive(problem, begun)
    groups, once = len({k.group for k in begun.free}), len(tried)
    assert once > groups  # some first steps were too short, or too long
    tried.clear()
    again = derive(problem, first, anew=True)
    assert groups <= len(tried) < once
    old, new = (np.linalg.norm(s.jacobian, axis=0) for s in (first, again))
    assert np.all(
        np.sum(first.jacobian * again.jacobian, axis=0) > 0.6 * old * new
    )  # a step shows a dozen floors
    tried.clear()
    assert derive(problem, first) is not None
    assert not tried


@pytest.mark.parametrize("extra", [None, "rts", "row_fpn"])
def test_many_derivatives_are_taken_on_half_of_the_field_where_that_tells_them(extra, monkeypatch):
    """The level and the shading but lack what is chance in the other half."""
    problem, model = small.fit_problem_of(), small.model()
    if extra is not None:
        model = model.with_effect(small.KNOWN[extra]())
    begun, benches = start(problem, model), []
    whole = FitProblem.several

    def seen(self, models):
        benches.append((self.even, len(models)))
        return whole(self, models)

    monkeypatch.setattr(FitProblem, "several", seen)
    monkeypatch.setattr(derivatives, "_rescaled", lambda size, _: np.ones_like(size))
    derived = derive(problem, begun)
    np.testing.assert_array_equal(derived.train, begun.train)
    together = derived.jacobian
    assert {even for even, count in benches if count > SEVERAL} == {extra != "row_fpn"}
    benches.clear()
    groups = {k.group for k in begun.free}
    alone = [derive(problem, begun, only=lambda k, g=g: k.group == g).jacobian for g in groups]
    assert not any(even for even, _ in benches)
    one_by_one = np.nanmean(alone, axis=0)
    shaded = np.array(["shading" in n or n in ("mean", "median") for n in problem.train.names])
    np.testing.assert_allclose(together[~shaded], one_by_one[~shaded], rtol=1e-9, atol=1e-9)
    apart = np.linalg.norm(together - one_by_one, axis=0)
    assert np.all(apart < 0.3 * np.linalg.norm(one_by_one, axis=0))


@pytest.mark.parametrize(("span", "fixed"), [(1.6, True), (20.0, False)])
def test_an_energy_is_held_where_the_temperatures_tell_no_slope(span, fixed):
    problem = small.fit_problem_of()
    settings = tuple(
        replace(s, point=replace(s.point, temperature_c=25.0 + span * (n > 0)))
        for n, s in enumerate(problem.plan.captures.settings)
    )
    captures = replace(problem.plan.captures, settings=settings)
    problem = replace(problem, plan=replace(problem.plan, captures=captures))
    model = small.model().with_effect(small.KNOWN["hot_pixels"](fraction=0.05, scale=200.0))
    free = [
        k for k in free_parameters(model) if k.effect == "hot_pixels" and k.parameter == "ea_ev"
    ]
    found = derive(problem, start(problem, model, free))
    assert (np.linalg.norm(found.jacobian) == 0) == fixed
