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


def test_jitter_of_one_set_point_is_one_temperature_for_all_exposures():
    # two codes of a thermometer with steps of .43 C, mixed otherwise at each exposure
    low, high = -17.37, -16.94
    points = [(low, 120.0)] * 9 + [(high, 120.0)] * 3 + [(low, 300.0)] + [(high, 300.0)] * 4
    found = group(frames(*points, (low, 900.0)))
    assert [len(s.frames) for s in found] == [12, 5, 1]
    mean = (10 * low + 3 * high + low + 4 * high) / 18
    (shared,) = {s.point.temperature_c for s in found}
    assert shared == pytest.approx(mean, abs=1e-6)


def test_several_set_points_have_one_temperature_each_whatever_the_exposure():
    rng = np.random.default_rng(0)
    points = [(t + rng.normal(0, 0.1), e) for t in (25.0, 35.0, 45.0) for e in (1.0, 2.0, 4.0, 8.0)]
    found = group(frames(*points))
    temperatures = sorted({s.point.temperature_c for s in found})
    assert temperatures == pytest.approx([25, 35, 45], abs=0.2)
    assert len(found) == 12


def test_set_points_nearer_than_the_tolerance_are_told_by_their_scatter():
    points = [(t + 0.01 * k, 1.0) for t in (20.0, 21.0, 22.0) for k in range(4)]
    found = group(frames(*points))
    assert [len(s.frames) for s in found] == [4, 4, 4]
    assert [s.point.temperature_c for s in found] == pytest.approx([20.015, 21.015, 22.015])
    given = group(frames(*points), 1.5)  # a tolerance that is given decides alone
    assert sorted(len(s.frames) for s in given) == [4, 8]


def test_a_dense_series_keeps_the_temperatures_of_its_own_frames():
    # cooling by .5 C a frame, two exposures in turn: no cluster stands alone
    points = [(20.0 - 0.5 * k, 1.0 + k % 2) for k in range(40)]
    found = group(frames(*points))
    for setting in found:
        own = [f.point.temperature_c for f in setting.frames]
        assert setting.point.temperature_c == pytest.approx(np.mean(own), abs=1e-6)
        assert max(own) - min(own) <= 1.5
    assert len({s.point.temperature_c for s in found}) > 20


def test_a_span_is_cut_at_its_widest_gap():
    found = group(frames((7.1,), (8.4,), (8.7,)), 1.5)
    assert names(found) == [["0"], ["1", "2"]]


def test_many_temperatures_are_clustered_in_time():
    found = group(frames(*[(0.01 * k,) for k in range(20_000)]), 0.0)
    assert len(found) == 20_000


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
