import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from dnanalyze.analyzers.kernels.sorting import order_statistic, radix_sorted

numbers = hnp.arrays(np.float32, st.integers(1, 300), elements=st.floats(width=32, allow_nan=False))


@given(numbers)
def test_radix_sort_agrees_with_numpy(values):
    np.testing.assert_array_equal(radix_sorted(values), np.sort(values))


@given(numbers, st.data())
def test_an_order_statistic_is_that_of_the_sorted_sample(values, data):
    place = data.draw(st.integers(0, values.size - 1))
    level, below, alike = order_statistic(values, place)
    assert level == np.sort(values)[place]
    assert (below, alike) == (np.sum(values < level), np.sum(values == level))


@pytest.mark.parametrize("centre", [0.0, 100.0, -3e4])
def test_noise_about_any_level_is_sorted(centre):
    values = np.random.default_rng(1).normal(centre, 3.0, 100_000).astype(np.float32)
    np.testing.assert_array_equal(radix_sorted(values), np.sort(values))
    assert order_statistic(values, 99_000)[0] == np.sort(values)[99_000]
