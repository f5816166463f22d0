"""The Wang 2025 model beside a compared model."""

from __future__ import annotations

import pytest

from dnanalyze.comparator.compare import compare_on, compared, paper_model
from dnanalyze.demo import tiny
from dnanalyze.fitting.fit import paper_start
from dnanalyze.fitting.problem import problem_of
from dnanalyze.fitting.yardstick import by_design
from dnanalyze.model.effects.row_noise import RowNoise


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
