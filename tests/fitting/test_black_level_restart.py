"""A fit that rests far from the measured black level begins again there."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import small_series as small

from dnanalyze.fitting.black_level_restart import at_black_level
from dnanalyze.fitting.derivatives import derive
from dnanalyze.fitting.design import design
from dnanalyze.fitting.moments import moments
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.state import start
from dnanalyze.fitting.ties import Tie
from dnanalyze.model.laws import TableLaw
from dnanalyze.model.simulate import simulate

BLACK, NOISE, GAIN = 64.0, 1.5, 0.5  # DN, DN, DN/e-


def series(seed: int, black: float = BLACK):
    """1, 4 and 16 DN above the black level; of another one with the same levels and noise."""
    base = small.model().get("convolved_lognormal")
    signal = np.array([1.0, 4.0, 16.0]) + BLACK - black
    points = tuple(replace(p, exposure_s=None) for p in small.POINTS)
    base = replace(base, mu=TableLaw(points, tuple(np.log(signal).tolist())))
    read = math.sqrt(NOISE**2 - GAIN * (BLACK - black))
    made = small.model(dark_shot_noise={"dn_per_e": GAIN}, read_noise={"sigma": read})
    return replace(made.with_effect(base), pedestal=black, seed=seed)


@pytest.fixture(scope="module")
def problem():
    return fit_problem(design(simulate(series(9), (256, 256), [(p, 4) for p in small.POINTS])))


def at_rest(problem, model):
    return derive(problem, start(problem, model))


@pytest.mark.parametrize("black", [63.0, 64.6])
def test_a_black_level_that_read_noise_and_charge_hide_comes_back(problem, black):
    state = at_rest(problem, series(4, black))
    ended = at_black_level(problem, state, 12)
    # the median of 256^2 / 2 pixels repeats to .01 DN; three temperatures tell the level to .05
    assert ended.model.pedestal == pytest.approx(BLACK, abs=0.15)
    assert ended.merit < state.merit


def test_a_fit_at_the_level_by_the_moments_stays(problem):
    measured = moments(Readings(problem.measured[0]), None).pedestal
    state = at_rest(problem, series(4, measured + 0.04))  # of .05 of the noise
    assert at_black_level(problem, state, 12) is state


def test_a_black_level_that_is_bound_stays(problem):
    state = at_rest(problem, series(4, 63.0))
    at = next(i for i, k in enumerate(state.free) if k.effect == "pedestal")
    bound = replace(state, ties=(Tie(at, 63.0, 0.01),))
    assert at_black_level(problem, bound, 12) is bound
