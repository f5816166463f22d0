from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import median_abs_deviation

from dnanalyze.robust import robust_deviation


def test_it_is_the_deviation_of_normal_values_with_a_tail_beside_them():
    values = np.random.default_rng(1).normal(5.0, 2.0, 20_000)
    values[:200] += 1e4
    # the median absolute deviation of n normal values scatters by 1.17 / sqrt(n); the tail, 1 % of
    # them, moves it by about 1.4 %
    assert robust_deviation(values) == pytest.approx(2.0, rel=0.05)


def test_it_agrees_with_scipy_and_takes_another_centre():
    values = np.random.default_rng(2).normal(0.0, 1.0, (7, 9))
    expected = median_abs_deviation(values, axis=None, scale="normal")
    assert robust_deviation(values) == pytest.approx(expected, rel=1e-4)
    assert robust_deviation(np.array([1.0, 2.0, 3.0]), 0.0) == pytest.approx(2 * 1.4826)
