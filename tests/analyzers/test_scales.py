"""Errors on the scale of a statistic, and in its unit."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dnanalyze.analyzers.statistics import Scale

positive = st.floats(0.01, 1e4)


@given(st.sampled_from(list(Scale)), positive)
def test_a_small_error_in_plain_units_is_that_of_the_ends(scale, value):
    error = 1e-4
    low, high = scale.ends(value, error, 1.0)
    assert low < value < high
    assert scale.plain_error(value, error) == pytest.approx((high - low) / 2.0, rel=1e-3)


def test_ends_of_known_scales():
    assert Scale.LOG.ends(4.0, 0.1, 2.0) == pytest.approx((4 * math.exp(-0.2), 4 * math.exp(0.2)))
    assert Scale.LINEAR.ends(1.0, 0.5, 2.0) == (0.0, 2.0)
    low, high = Scale.ROOT.ends(0.0, 1.0, 2.0)
    assert low == 0.0
    assert high == pytest.approx((0.375**0.5 + 1) ** 2 - 0.375)
    assert Scale.RATIO.ends(1.0, math.log(2.0), 1.0) == pytest.approx((0.0, 3.0))


def test_a_count_has_the_error_of_poisson():
    # 2 sqrt(n + 3/8) has the standard deviation 1, n that of sqrt(n + 3/8)
    assert Scale.ROOT.plain_error(100.0, 1.0) == pytest.approx(10.0, rel=2e-3)


def test_without_a_place_on_the_scale_there_is_no_error():
    assert math.isnan(Scale.LOG.plain_error(0.0, 0.1))
    assert Scale.LOG.ends(0.0, 0.1, 2.0) == (0.0, 0.0)
    assert Scale.LOG.ends(1.0, math.nan, 2.0) == (1.0, 1.0)
