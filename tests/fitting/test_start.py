"""Initial models by the method of moments, of captures at the ends of what a camera may give."""

import numpy as np
import pytest

from dnanalyze import OperatingPoint, from_arrays
from dnanalyze.fitting.design import design
from dnanalyze.fitting.fit import baseline_model, paper_start
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.model.registry import BASE

WARM, HOT = OperatingPoint(20.0, 100.0), OperatingPoint(60.0, 0.001)


@pytest.mark.parametrize(
    ("scatter", "hot"),
    [(8e3, 2e4), (10.0, 5e4)],
    ids=["a fixed pattern of 8,000 DN", "50,000 DN after 1 ms"],
)
def test_moments_of_large_signals_stay_within_the_bounds_of_the_model(scatter, hot):
    rng = np.random.default_rng(3)
    pattern = 3e4 + scatter * rng.standard_normal((48, 64))
    captures = from_arrays(
        {
            point: level + pattern + 20.0 * rng.standard_normal((3, 48, 64))
            for point, level in ((WARM, 0.0), (HOT, hot))
        }
    )
    problem = fit_problem(design(captures))
    bounds = paper_start(problem).get(BASE).parameters()["mu"]
    for model in (paper_start(problem), baseline_model(problem)):
        values = [model.get(BASE).value("mu", point) for point in (WARM, HOT)]
        assert all(bounds.lower <= mu <= bounds.upper for mu in values)
