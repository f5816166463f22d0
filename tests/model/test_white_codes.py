import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dnanalyze.model.white_codes import FIELD, left_of, likeness, noise_before, reached


@pytest.mark.parametrize("sigma", [0.6, 5.0])
def test_of_no_filter_the_noise_and_a_twelfth_are_left(sigma):
    left = left_of(lambda codes: codes, sigma)
    expected = sigma**2 + 1 / 12
    assert left.var() == pytest.approx(expected, rel=5 * np.sqrt(2) / FIELD)
    assert abs(likeness(left)) < 5 / FIELD
    assert noise_before(lambda codes: codes, np.sqrt(expected)) == pytest.approx(sigma, rel=0.05)


def test_of_a_mean_of_two_half_the_variance_is_left_and_neighbours_are_half_alike():
    def pairs(codes):
        return (codes + np.roll(codes, 1, axis=1)) / 2.0

    left = left_of(pairs, 5.0)
    left[:, 0] = 0.0  # the last column is rolled in there
    assert left.var() == pytest.approx(12.5, rel=7 * np.sqrt(2) / FIELD)
    assert likeness(left) == pytest.approx(0.5, abs=5 / FIELD)
    assert noise_before(pairs, 5.0) == pytest.approx(5.0 * np.sqrt(2), rel=0.05)


def test_what_takes_all_away_has_the_most_noise_before_that_is_tried():
    assert noise_before(np.zeros_like, 1.0) == pytest.approx(6.0)
    assert likeness(np.zeros((8, 8))) == 0.0


@given(st.lists(st.floats(-5, 5), min_size=1, max_size=12), st.floats(-6, 6))
def test_a_level_is_reached_where_the_highest_so_far_exceeds_it(heights, level):
    """As found with all of them known; none is asked for beyond."""
    asked, places = [], 10.0 * np.arange(len(heights))

    def rise(place):
        asked.append(place)
        return heights[int(place / 10)]

    found = reached(level, rise, places)
    assert found == np.interp(level, np.maximum.accumulate(heights), places)
    assert not any(heights[int(p / 10)] > level for p in asked[:-1])
