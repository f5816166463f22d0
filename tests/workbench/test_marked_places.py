"""Statistics find their pixels, rows and columns in images with known ones."""

import numpy as np
import pytest

from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.workbench.places import kind_of, places


@pytest.fixture
def image():
    return np.random.default_rng(7).normal(100.0, 1.0, (64, 96))


def test_deviating_rows_and_columns_are_marked(image):
    image[:, [10, 50]] += 5.0
    image[33] -= 5.0
    assert places("column_outliers", image).columns.tolist() == [10, 50]
    assert places("pattern_columns_0.1_0.3", image).columns.tolist() == [10, 50]
    assert places("row_extreme", image).rows.tolist() == [33]
    assert places("dsnu_1288_row", image).rows.tolist() == [33]


def test_the_phase_of_a_period_and_the_ends_of_taps_are_marked(image):
    image[:, 3::8] += 2.0
    assert places("column_periodic_8", image).columns.tolist() == list(range(3, 96, 8))
    assert places("column_taps_4", image).columns.tolist() == [24, 48, 72]


def test_the_farthest_pixels_of_the_side_are_marked(image):
    image[5, 6], image[7, 8] = 900.0, -900.0
    hot, cold = (places(n, image).pixels.tolist() for n in ("hot_count_8", "cold_count_5"))
    assert [5, 6] in hot
    assert [7, 8] in cold
    assert [7, 8] not in hot


@pytest.mark.parametrize(
    "name", ["mean", "temporal_row_noise", "drift", "frame_slope_mid", "lattice"]
)
def test_a_statistic_without_a_place_marks_nothing(name, image):
    assert name in catalogue()
    assert kind_of(name) is None
    assert places(name, image) is None


def test_every_statistic_of_the_catalogue_is_answered_on_a_small_image_too():
    small = np.zeros((4, 6))
    for name in catalogue():
        found = places(name, small)
        assert (found is None) == (kind_of(name) is None)
