from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import median_abs_deviation

from dnanalyze.robust import core_deviation, robust_deviation


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


@pytest.mark.parametrize("sigma", [0.4, 0.6, 1.0, 3.0])
def test_the_core_of_rounded_values_has_the_deviation_of_the_codes(sigma):
    """Where the middle lies between two codes or on one: within a third, and never 0."""
    draws = np.random.default_rng(3).normal(0.0, sigma, 20_000)
    for middle in (8.0, 8.25):
        codes = np.round(middle + draws)
        assert core_deviation(codes) == pytest.approx(np.std(codes), rel=1 / 3)
    assert core_deviation(np.append(draws, [1e4] * 200)) == pytest.approx(sigma, rel=0.05)


def test_values_that_are_all_the_same_have_no_deviation():
    assert core_deviation(np.full((3, 4), 7.0)) == 0.0
