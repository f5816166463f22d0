"""Operating points that frames do not tell apart, taken as one."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.fitting.design import design
from dnanalyze.fitting.pooling import DRIFT, MOST, pooled
from dnanalyze.fitting.whole_field import coverage
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting

SHAPE = (128, 96)
NOISE = 2.0


def setting(frames, temperature=-100.0, exposure=0.0, gain=1.0):
    point = OperatingPoint(temperature, exposure, gain)

    def load(pixels):
        return lambda window: pixels if window is None else pixels[window.slices]

    made = [Frame(f"frame_{n}", point, load(pixels)) for n, pixels in enumerate(frames)]
    return Setting(point, tuple(made))


def frames(rng, count=1, level=100.0, noise=NOISE, hot=0, shape=SHAPE):
    """Frames of one sensor: its pattern is larger than the noise."""
    pattern = np.random.default_rng(1).normal(0.0, 5.0, shape)
    mean = level + pattern
    mean.flat[rng.choice(mean.size, hot, replace=False)] += 100.0
    return [mean + rng.normal(0.0, noise, shape) for _ in range(count)]


def test_single_frames_of_many_temperatures_are_frames_of_one_operating_point():
    rng = np.random.default_rng(2)
    settings = [setting(frames(rng), -100.0 - 3.0 * n) for n in range(5)]
    [(found, members)] = pooled(settings, SHAPE)
    assert members == 5
    assert found.point == settings[2].point
    assert len(found.frames) == 5


def test_equal_points_are_told_apart_once_in_three_hundred_at_most():
    """Three tests of 0.1 % each."""
    rng = np.random.default_rng(3)
    pairs = 200
    apart = sum(
        len(pooled([setting(frames(rng), -100.0), setting(frames(rng), -90.0)], SHAPE)) == 2
        for _ in range(pairs)
    )
    assert apart <= 4  # binomial, 200 of 0.3 %: more than 4 once in 3,000


@pytest.mark.parametrize(
    "other",
    [
        {"level": 100.0 + 2.0 * DRIFT * NOISE},  # dark signal, or another session
        {"noise": 1.3 * NOISE},
        {"hot": 30},  # pixels, of charge that the first has not
    ],
    ids=lambda case: next(iter(case)),
)
def test_a_difference_beyond_noise_keeps_two_points(other):
    rng = np.random.default_rng(4)
    two = [setting(frames(rng), -100.0), setting(frames(rng, **other), -90.0)]
    assert len(pooled(two, SHAPE)) == 2


def test_few_hits_that_move_neither_level_nor_noise_keep_two_points():
    """Sixteen of 200,000 pixels: a binomial test of one side alone, 3e-5."""
    rng, shape = np.random.default_rng(12), (512, 384)
    equal, hit = (
        [setting(frames(rng, hot=hot, shape=shape), -100.0 + 10.0 * n) for n, hot in pair]
        for pair in (((0, 0), (1, 0)), ((0, 0), (1, 16)))
    )
    assert len(pooled(equal, shape)) == 1
    assert len(pooled(hit, shape)) == 2


def test_a_small_step_of_the_level_is_a_drift_between_equal_exposures_alone():
    rng = np.random.default_rng(5)
    low, high = frames(rng), frames(rng, level=100.0 + 0.7 * DRIFT * NOISE)
    assert len(pooled([setting(low), setting(high, -90.0)], SHAPE)) == 1
    assert len(pooled([setting(low), setting(high, exposure=60.0)], SHAPE)) == 2


def test_points_of_other_gains_or_with_frames_enough_are_not_pooled():
    rng = np.random.default_rng(6)
    gains = [setting(frames(rng), gain=1.0), setting(frames(rng), gain=2.0)]
    assert [n for _, n in pooled(gains, SHAPE)] == [1, 1]
    several = [setting(frames(rng, 3), -100.0), setting(frames(rng, 3), -90.0)]
    assert [n for _, n in pooled(several, SHAPE)] == [1, 1]
    warm = setting(frames(rng, level=300.0), 20.0)  # of one frame, so that frames are looked at
    assert [n for _, n in pooled([*several, warm], SHAPE)] == [1, 1, 1]


def test_a_fit_sees_the_pool_and_says_so():
    rng = np.random.default_rng(7)
    settings = tuple(setting(frames(rng), -100.0 - n) for n in range(4))
    captures = CaptureSet("cold", Sensor(SHAPE), settings)
    plan = design(captures)
    assert plan.settings == [(settings[2].point, 4)]
    seen = coverage(plan)
    assert (seen.settings, seen.all_settings, seen.pooled, seen.pools) == (4, 4, 4, 1)
    as_it_is = design(captures, pool=False)
    assert [n for _, n in as_it_is.settings] == [1, 1, 1, 1]


def test_of_very_many_operating_points_some_are_looked_at():
    rng = np.random.default_rng(9)
    settings = [setting(frames(rng, level=100.0 + 3.0 * n), -100.0 + n) for n in range(MOST + 2)]
    found = pooled(settings, SHAPE)
    assert len(found) == MOST // 2 + 1
    assert found[0][0].point == settings[0].point


def test_frames_without_values_are_kept_apart():
    rng = np.random.default_rng(10)
    broken = frames(rng)
    broken[0][:, 10] = np.nan
    assert len(pooled([setting(broken), setting(frames(rng), -90.0)], SHAPE)) == 2


def test_levels_are_told_apart_in_codes_that_most_pixels_share():
    rng = np.random.default_rng(11)

    def coded(level):
        return [np.rint(level + rng.normal(0.0, 0.3, SHAPE))]

    equal = [setting(coded(8.1)), setting(coded(8.1), exposure=0.1)]
    assert len(pooled(equal, SHAPE)) == 1
    assert len(pooled([setting(coded(8.1)), setting(coded(8.2), exposure=0.1)], SHAPE)) == 2
