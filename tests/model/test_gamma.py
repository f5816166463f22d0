"""Gamma deviates against the quantiles of SciPy."""

import numpy as np
import pytest
from scipy import stats

from dnanalyze.model.gamma import gamma_deviates


@pytest.mark.parametrize("rms", [1e-3, 0.1, 1.0, 2.0])
def test_gamma_deviates_are_the_quantiles(rms):
    normal = np.linspace(-4.5, 4.5, 101)
    expected = stats.gamma(1 / rms**2, scale=rms**2).ppf(stats.norm.cdf(normal))
    np.testing.assert_allclose(gamma_deviates(normal, rms), expected, rtol=1e-4, atol=2e-5 * rms)
