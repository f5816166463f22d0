"""Derivatives and the steps they are taken with."""

from dataclasses import replace

import numpy as np
import pytest
import small_series as small

from dnanalyze.fitting import least_squares
from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import derive, given, minimise, start
from dnanalyze.fitting.predictor import Bench


def test_known_derivatives_size_the_steps_of_new_ones(monkeypatch):
    held, tried = small.bench_of(), []
    whole = Bench.fitted_z

    def counted(self, other):
        tried.append(other)
        return whole(self, other)

    monkeypatch.setattr(Bench, "fitted_z", counted)
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


@pytest.mark.parametrize(("kept", "rounds"), [(0.995, 2), (0.9, 3), (0.5, 6)])
def test_a_fit_that_falls_steeply_is_given_more_rounds(kept, rounds, monkeypatch):
    made = []

    def lower(_bench, state, *_, **__):
        made.append(state)
        return replace(state, train=kept**0.5 * state.train)

    monkeypatch.setattr(least_squares, "minimise", lower)
    monkeypatch.setattr(least_squares, "derive", lambda _bench, state, **_: state)
    begun = least_squares.State(
        None, [], np.full(1000, 2.0), given(np.zeros(1)), np.zeros((1000, 0))
    )
    least_squares.converge(None, begun)
    assert len(made) == rounds


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
