"""What a fit says of parameters that the captures do not determine."""

import numpy as np
import pytest

from dnanalyze.fitting.fit import _doubts
from dnanalyze.fitting.free_parameters import free_parameters
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.registry import built_in


@pytest.mark.parametrize(
    ("spread", "factor"), [(0.9, None), (2.0, "7.39"), (6.8, "898"), (60.0, "more than 1,000")]
)
def test_a_factor_is_stated_up_to_a_thousand(spread, factor):
    (sigma, *_) = free_parameters(NoiseModel((built_in()["column_fpn"](sigma=1.0),), 64.0))[1:]
    assert sigma.name == "column_fpn.sigma"
    found = _doubts([sigma], np.array([spread]), np.eye(1), np.array([True]))
    expected = [f"not determined: column_fpn.sigma, within a factor of {factor}"]
    assert found == (expected if factor else [])
