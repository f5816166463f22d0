"""The Wang 2025 model beside a compared model."""

from __future__ import annotations

from dataclasses import replace

import pytest

from dnanalyze.comparator.compare import compare_on, compared, paper_model
from dnanalyze.comparator.predictive_check import FittedModel
from dnanalyze.demo import tiny
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.problem import fit_problem, problem_of
from dnanalyze.fitting.state import start
from dnanalyze.fitting.yardstick import by_design
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.quantization import Quantization
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.row_noise import RowNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate


@pytest.fixture(scope="module")
def problem():
    return problem_of(tiny())


def test_the_model_with_which_a_search_began_is_not_fitted_again(problem):
    begun = paper_start(problem)
    assert paper_model(problem, begun) is begun
    assert paper_model(problem, begun.with_effect(RowNoise(1.0)), in_time=False) is None
    assert paper_model(problem, None, in_time=False) is None


def test_a_comparison_with_the_fitted_model_at_hand_is_that_which_fits_it(problem):
    whole = compare_on(tiny(), problem=problem)
    again = compared(tiny(), by_design(problem, whole.model), whole.model, whole.model)
    assert (again.error, again.baselines) == (whole.error, whole.baselines)
    assert again.baselines["paper"] == again.error
    alone = compared(tiny(), by_design(problem, whole.model), whole.model, None)
    assert set(alone.baselines) == {"gaussian"}
    assert paper_model(problem, None) == whole.model


def test_a_comparison_lists_what_simulated_sensors_do_not_show(problem):
    right = problem.plan.captures
    model = compare_on(tiny(), problem=problem).model.with_effect(RowNoise(20.0))
    found = compared(right, by_design(problem, model), model, None)
    there = by_design(problem, model)
    assert found.unexplained == FittedModel(there, start(there, model)).unexplained != []
    assert not found.adequate


def test_a_comparison_with_the_model_of_the_frames_leaves_nothing():
    point = OperatingPoint(25.0, 1.0, 1.0)
    model = NoiseModel((ReadNoise(4.0), PixelFpn(2.0), Quantization(12)), 64.0, point, 1)
    problem = fit_problem(design(simulate(model, (128, 128), [(point, 8)])))
    other = replace(model, seed=2)
    found = compared(problem.plan.captures, by_design(problem, other), other, None)
    assert found.unexplained == []
    assert found.adequate
