"""Where in a large field a model is fitted."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.analyzers.field_profile import field_profile
from dnanalyze.fitting.placement import placed

SHAPE, SIZE = (512, 768), (128, 192)


def window_of(structure, size=SIZE):
    rng = np.random.default_rng(7)
    frames = [100.0 + structure + rng.normal(0.0, 3.0, SHAPE) for _ in range(2)]
    return placed([field_profile(frames)], SHAPE, size, 2)


def test_a_field_without_structure_is_seen_in_its_middle():
    assert window_of(0.0).slices == (slice(192, 320), slice(288, 480))


@pytest.mark.parametrize(
    ("place", "wanted"),
    [
        ((slice(480, 512), slice(0, 32)), (511, 0)),
        ((slice(0, 6), slice(None)), (0, None)),
        ((slice(None), slice(701, 702)), (None, 701)),
        ((slice(None), slice(600, None)), (None, 600)),
    ],
    ids=["corner", "stripe", "column", "tap"],
)
def test_structure_is_looked_for_where_it_is(place, wanted):
    structure = np.zeros(SHAPE)
    structure[place] = 3.0
    window = window_of(structure)
    row, column = wanted
    assert row is None or window.top <= row < window.bottom
    assert column is None or window.left < column < window.right or column == window.left == 0
    assert window.shape == SIZE
    assert window.top % 2 == window.left % 2 == 0


def test_a_column_that_stands_out_by_little_is_seen_with_all_its_pixels():
    shape, size = (1200, 800), (600, 600)
    rng = np.random.default_rng(7)
    frames = [100.0 + rng.normal(0.0, 3.0, shape) for _ in range(2)]
    for frame in frames:
        frame[:, 701] += 0.5  # 8 standard deviations of a mean of 1200 pixels
    window = placed([field_profile(frames)], shape, size, 2)
    assert window.shape == (1200, 300)
    assert window.left <= 701 < window.right
    for frame in frames:
        frame[:64, :64] += 3.0  # a window of all rows would hold less of what it is among
    assert placed([field_profile(frames)], shape, size, 2).shape == size


def test_a_window_of_most_of_the_field_is_that_in_the_middle():
    structure = np.zeros(SHAPE)
    structure[508:] = 300.0
    assert window_of(structure, (480, 704)).slices == (slice(16, 496), slice(32, 736))
