from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from readout_bench import POINT, Given, frames
from scipy import ndimage

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.effects.dpc import Dpc, _brightest
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.effects.missing_codes import MissingCodes
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.guesses.dpc import HIGH_THRESHOLD

SHAPE = (192, 192)
SENSOR = (ConvolvedLognormal(1.0, 1.2, sigma=1e-6), ReadNoise(2.0))
ROUND = MissingCodes(1e-3)
RING = np.ones((3, 3), bool)
RING[1, 1] = False


def both(dpc, *more, **options):
    """A frame before and after the correction."""
    options = {"shape": SHAPE, "count": 1, **options}
    return frames(*SENSOR, *more, **options)[0], frames(*SENSOR, *more, dpc, **options)[0]


def around(image, function, size=3):
    footprint = np.ones((size, size), bool)
    footprint[size // 2, size // 2] = False
    return ndimage.generic_filter(image, function, footprint=footprint, mode="mirror")


@pytest.mark.parametrize("spacing", [1, 2])
def test_median_rule_within_a_plane(spacing):
    before, after = both(Dpc(6.0, kind="median", replacement="midpoint", spacing=spacing))
    for dy in range(spacing):
        for dx in range(spacing):
            plane = before[dy::spacing, dx::spacing]
            middle = around(plane, np.median)
            expected = np.where(plane - middle > 6.0, middle, plane)
            np.testing.assert_allclose(after[dy::spacing, dx::spacing], expected, atol=1e-4)


@pytest.mark.parametrize("sides", ["hot", "both"])
def test_excess_rule_is_held_against_the_extremes(sides):
    before, after = both(Dpc(3.0, kind="excess", replacement="midpoint", sides=sides))
    high, low, middle = (around(before, f) for f in (np.max, np.min, np.median))
    hit = before > high + 3.0
    if sides == "both":
        hit |= before < low - 3.0
    assert hit.sum() > 20
    np.testing.assert_allclose(after, np.where(hit, middle, before), atol=1e-4)


def test_clamp_and_ratio_with_24_neighbours():
    before, after = both(Dpc(0.01, kind="clamp", neighbours=24))
    high = around(before, np.max, 5)
    np.testing.assert_allclose(after, np.where(before > high + 0.01, high, before))
    before, after = both(Dpc(1.0, 2.0, 64.0, kind="ratio", replacement="midpoint"))
    high, middle = around(before, np.max), around(before, np.median)
    hit = before - 64.0 > 2.0 * np.maximum(high - 64.0, 0.0) + 1.0
    assert hit.sum() > 10
    np.testing.assert_allclose(after, np.where(hit, middle, before), atol=1e-4)


def test_multiples_of_the_neighbours_median_and_of_the_least_that_counts():
    before, after = both(Dpc(3.0, 2.0, 64.0, kind="multiple", replacement="midpoint"))
    middle = around(before, np.median)
    hit = before - 64.0 > 2.0 * np.maximum(middle - 64.0, 3.0)
    low = middle - 64.0 < 3.0
    assert (hit & low).sum() > 10
    assert (hit & ~low).sum() > 10
    np.testing.assert_allclose(after, np.where(hit, middle, before), atol=1e-4)


def test_clamp_makes_maxima_rarer_and_ties_common():
    before, after = both(Dpc(0.01, kind="clamp"), ROUND)
    top = after > np.quantile(after, 0.99)
    high = ndimage.maximum_filter(after, footprint=RING, mode="mirror")
    assert np.mean((after == high)[top]) > 0.5
    assert not np.any(after > high)
    assert np.any(before > ndimage.maximum_filter(before, footprint=RING, mode="mirror"))


def test_codes_stay_codes():
    _, after = both(Dpc(4.0, replacement="mean"), ROUND)
    assert np.array_equal(after, np.rint(after))


def test_static_correction_replaces_the_brightest_of_the_silicon_at_every_setting():
    changed = []
    for point in (POINT, OperatingPoint(65.0, 1.0, 1.0)):
        y = frames(*SENSOR, count=3, shape=SHAPE, point=point)
        z = frames(
            *SENSOR,
            Dpc(fraction=0.002, kind="static", replacement="midpoint"),
            count=3,
            shape=SHAPE,
            point=point,
        )
        moved = np.any(z != y, axis=0)
        assert moved.sum() == round(0.002 * moved.size)
        np.testing.assert_allclose(z[:, moved][0], around(y[0], np.median)[moved], atol=1e-4)
        changed.append(moved)
    assert np.array_equal(*changed)
    steady = frames(*SENSOR, count=8, shape=SHAPE).mean(axis=0)
    assert steady[changed[0]].min() > np.quantile(steady, 0.99)


def test_idle_parameters():
    assert Dpc(kind="median").inactive_parameters() == ("factor", "black", "fraction", "neighbours")
    assert Dpc(kind="ratio").inactive_parameters() == ("fraction", "sides", "unit")
    assert set(Dpc(kind="static").inactive_parameters()) == {
        "threshold", "factor", "black", "sides", "unit", "neighbours",
    }  # fmt: skip


@pytest.mark.parametrize("kind", ["excess", "median", "clamp", "ratio", "multiple", "static"])
def test_idle_is_what_changes_nothing(kind):
    """And nothing else is: each kind is tried in all its forms, and in no others."""
    other = {
        "threshold": 3.0, "factor": 1.2, "black": 20.0, "fraction": 0.02, "sides": "both",
        "replacement": "mean", "unit": "local", "neighbours": 24,
    }  # fmt: skip
    effect = Dpc(threshold=6.0, factor=1.5, black=60.0, fraction=0.005, kind=kind)
    sensor = (ReadNoise(2.0), PixelFpn(4.0), HotPixels(0.02, 60.0))
    plain = frames(*sensor, effect, count=1)
    same = {
        name for name, value in other.items()
        if np.array_equal(frames(*sensor, replace(effect, **{name: value}), count=1), plain)
    }  # fmt: skip
    assert same == set(effect.inactive_parameters())


def test_guess_takes_the_threshold_from_what_is_missing():
    clues = Given(
        seen={"temporal_noise_core": 2.0, "median": 66.0},
        off={"excess_4": -1.0, "excess_8": -6.0, "excess_16": -9.0, "ties_max8": 4.0},
    )
    found = {e.kind: e for e in Dpc.guess(clues)}
    assert set(found) == {"excess", "median", "clamp", "ratio", "multiple"}
    assert found["median"].threshold == pytest.approx(16.0)
    assert {e.black for e in found.values()} == {66.0}  # each may turn out to be a multiple


def test_a_multiple_of_the_median_is_looked_at_low_and_first():
    """The fit without it has made the tail as short as it leaves it: little is missing above."""
    clues = Given(
        seen={"temporal_noise_core": 2.0, "median": 66.0},
        off={"excess_4": -4.0, "excess_8": -6.0, "hot_count_16": -7.0},
    )
    found = [e.threshold for e in Dpc.guess(clues) if e.kind == "multiple"]
    assert found == [4.0, 2.0]  # above black, of net signal: what noise reaches


def test_every_rule_is_among_the_guesses():
    """Which of them it is no count tells: one may promise all of it and another nothing."""
    clues = Given(
        seen={"temporal_noise_core": 2.0, "median": 66.0},
        off={"excess_4": -4.0, "excess_8": -6.0, "hot_count_16": -7.0},
    )
    found = {e.kind for e in Dpc.guess(clues)}
    assert found == {"excess", "median", "multiple", "clamp", "static", "ratio"}


def test_where_nothing_is_missing_up_to_far_out_the_usual_threshold_is_tried_too():
    """A bent fit lacks at the warmest setting alone what stands out by 16 deviations."""
    clues = Given(
        points=tuple(OperatingPoint(t, 1.0, 1.0) for t in (25.0, 45.0, 65.0)),
        seen={"temporal_noise_core": [2.0, 2.0, 40.0], "excess_4": 120.0, "excess_8": 90.0,
              "excess_16": [40.0, 40.0, 2.0]},
        model={"excess_4": 100.0, "excess_8": 80.0, "excess_16": 40.0},
        off={"excess_16": -6.0},
    )  # fmt: skip
    far, usual, _ = (e.threshold for e in Dpc.guess(clues) if e.kind == "excess")
    assert 8 * 40.0 < far < 16 * 40.0
    assert usual == pytest.approx(16 * 2.0)
    assert [e.threshold for e in Dpc.guess(clues) if e.sides == "both"] == [usual]
    clues.seen["temporal_noise_core"] = 2.0
    near, _ = (e.threshold for e in Dpc.guess(clues) if e.kind == "excess")
    assert near < HIGH_THRESHOLD * usual


def test_settings_of_different_noise_bracket_the_threshold():
    clues = Given(
        points=(OperatingPoint(25.0, 1.0, 1.0), OperatingPoint(65.0, 1.0, 1.0)),
        seen={
            "temporal_noise_core": [2.0, 3.0],  # leads of 8, 16, 32 and of 12, 24, 48 DN
            "excess_4": [90.0, 70.0], "excess_8": [30.0, 0.0], "excess_16": [0.0, 0.0],
        },
        model={"excess_4": 100.0, "excess_8": 40.0, "excess_16": 20.0},
        off={"excess_8": -6.0},
    )  # fmt: skip
    found = {e.kind: e for e in Dpc.guess(clues)}
    assert 16.0 < found["excess"].threshold < 24.0


def test_guess_of_a_list_from_what_the_tail_lacks():
    tail = ["pattern_q0.9", "pattern_q0.99", "pattern_q0.999", "pattern_q0.9999"]
    clues = Given(
        seen=dict(zip(tail, (10.0, 20.0, 30.0, 35.0), strict=True)),
        model=dict(zip(tail, (10.0, 20.0, 40.0, 60.0), strict=True)),
        off=dict(zip(tail, (0.0, 0.0, -9.0, -20.0), strict=True)),
    )
    found = {e.kind: e for e in Dpc.guess(clues)}
    # 35 DN lie three quarters of the way from the 99 % to the 99.9 % quantile of the model
    assert found["static"].fraction == pytest.approx(10 ** -(2 + 0.75))


def test_guess_of_a_list_from_the_hot_pixels_that_are_not_there():
    clues = Given(
        seen={"temporal_noise_core": 2.0, "hot_count_16": 2.0},
        model={"hot_count_16": 60.0}, off={"hot_count_16": -7.0},
    )  # fmt: skip
    (effect,) = Dpc.guess(clues)
    assert (effect.kind, effect.fraction) == ("static", pytest.approx(58 / 65536))
    assert Dpc.guess(Given()) == []


def test_a_list_made_where_it_is_warm_holds_what_is_hot_there():
    hot, share = OperatingPoint(65.0, 1.0, 1.0), 0.01
    sensor = (ReadNoise(0.5), PixelFpn(10.0), HotPixels(share, 5.0, ea_ev=0.7))
    bare = frames(*sensor, count=1, point=hot)[0]
    sites = frames(HotPixels(share, 5.0, ea_ev=0.7), count=1, point=hot)[0] - 64.0 > 60.0
    assert sites.sum() > 50
    # grown 25-fold, the hot pixels stand far out of offsets that hide them at the reference
    cold, warm = (Dpc(fraction=share, warmer=by, kind="static") for by in (0.0, 40.0))
    left, gone = (frames(*sensor, d, count=1, point=hot)[0] != bare for d in (cold, warm))
    assert gone[sites].mean() > 0.9
    assert left[sites].mean() < 0.5


def test_the_guess_takes_the_list_for_one_of_the_warmest_setting():
    points = tuple(OperatingPoint(t, 1.0, 1.0) for t in (15.0, 25.0, 65.0))
    clues = Given(points=points, off={"hot_count_16": [-9.0] * 3})
    assert {effect.warmer for effect in Dpc.guess(clues)} == {40.0}


@given(st.lists(st.integers(0, 5), min_size=1, max_size=40), st.data())
def test_the_list_has_the_brightest_pixels_and_of_equal_ones_the_first(values, data):
    count = data.draw(st.integers(0, len(values)))
    ranks = sorted(range(len(values)), key=lambda n: (-values[n], n))
    found = _brightest(np.array(values, np.float32), count)
    assert set(np.flatnonzero(found)) == set(ranks[:count])
