"""Derivatives and the steps they are taken with."""

import numpy as np
import small_series as small

from dnanalyze.fitting.knobs import knobs_of
from dnanalyze.fitting.least_squares import derive, start
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
