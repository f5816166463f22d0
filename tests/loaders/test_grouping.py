"""Frames fall into settings by what they share."""

import numpy as np
import pytest

from dnanalyze.loaders.captures import Frame, OperatingPoint
from dnanalyze.loaders.files import natural_key
from dnanalyze.loaders.grouping import group


def frames(*points, order=None):
    load = lambda window: np.zeros((8, 8))  # noqa: E731
    made = [Frame(str(k), OperatingPoint(*p), load) for k, p in enumerate(points)]
    return list(zip(made, order or [None] * len(made), strict=True))


def names(settings):
    return [[f.name for f in s.frames] for s in settings]


def test_a_group_spans_at_most_the_tolerance():
    # each neighbour is close, but the chain is longer than the tolerance
    found = group(frames((0.0,), (1.0,), (2.0,), (3.0,)), 1.5)
    assert names(found) == [["0", "1"], ["2", "3"]]
    assert [s.point.temperature_c for s in found] == [0.5, 2.5]


def test_the_point_has_the_mean_temperature_and_frames_keep_their_own():
    (found,) = group(frames((-7.0, 5.0), (-8.2, 5.0), (-7.0, 5.0)), 1.5)
    assert found.point.temperature_c == pytest.approx(-7.4)
    assert [f.point.temperature_c for f in found.frames] == [-7.0, -8.2, -7.0]


def test_equal_temperatures_are_kept_exactly():
    (found,) = group(frames(*[(0.1,)] * 3), 0.0)
    assert found.point.temperature_c == 0.1


def test_a_cooling_series_is_one_setting_a_frame():
    temperatures = [-15.0 - 4.0 * k for k in range(20)]
    found = group(frames(*[(t,) for t in temperatures]), 1.5)
    assert [s.point.temperature_c for s in found] == sorted(temperatures)


def test_exposure_gain_and_channel_part_settings_unknown_apart_from_known():
    points = [
        (25.0, 1.0, 1.0, "hcg"), (25.0, 1.0, 1.0, "lcg"), (25.0, 1.0, 2.0, "hcg"),
        (25.0, 0.0, 1.0, "hcg"), (None, 1.0, 1.0, "hcg"), (25.0, None, 1.0, "hcg"),
        (25.0, 1.00000001, 1.0, "hcg"),
    ]  # fmt: skip
    found = group(frames(*points), 1.5)
    assert sorted(names(found)) == [["0", "6"], ["1"], ["2"], ["3"], ["4"], ["5"]]
    keys = [s.point.sort_key() for s in found]
    assert keys == sorted(keys)


def test_order_is_the_frame_number_then_as_given():
    found = group(frames((1.0,), (1.2,), (0.9,), (1.1,), order=[2, 0, None, 1]), 1.5)
    assert names(found) == [["1", "3", "0", "2"]]


def test_natural_order():
    assert sorted(["d10", "d9", "D1", "d2b", "d2a"], key=natural_key) == [
        "D1", "d2a", "d2b", "d9", "d10",
    ]  # fmt: skip
