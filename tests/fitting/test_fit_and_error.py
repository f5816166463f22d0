"""A fit lowers the model error that is reported, whatever the model lacks."""

import numpy as np
import pytest

from dnanalyze.comparator.error import pooled
from dnanalyze.demo import draw_sensor, generate
from dnanalyze.fitting.fit import fit_on, paper_start
from dnanalyze.fitting.problem import problem_of
from dnanalyze.fitting.yardstick import by_design


@pytest.mark.parametrize("missing", ["column_fpn", "amp_glow"])
def test_a_fit_of_a_model_that_lacks_an_effect_lowers_the_model_error(missing):
    """By the yardstick of the start, on the half that the fit did not see."""
    rng = np.random.default_rng(3)
    captures = generate(draw_sensor(rng), {missing: "strong"}, (96, 144), frames=3, seed=3)
    problem = problem_of(captures)
    begun = paper_start(problem)
    ended = fit_on(captures, begun, replicates=0, problem=problem).model
    scaled = by_design(problem, begun)
    errors = [pooled(scaled.held_out_z(m), scaled.test.families) for m in (begun, ended)]
    # of sampling: each family's root mean square of some ten numbers, of nine families
    assert errors[1] < 1.1 * errors[0]
