from __future__ import annotations

import numpy as np
import pytest

from dnanalyze import NoiseModel, OperatingPoint, catalogue, simulate
from dnanalyze.classifier.pictures import around_zero, clipped_mean, code_step, compact_frames
from dnanalyze.classifier.places import FOLDS, places
from dnanalyze.loaders.captures import Sensor

WHERE = places((64, 64))


def test_the_step_of_codes(rng):
    codes = rng.integers(0, 50, (2, 30, 30))
    assert code_step(16.0 * codes + 5) == 16.0
    assert code_step(codes.astype(float)) == 1.0
    assert code_step(codes + 0.5) == 0.0
    assert code_step(np.full((3, 3), 7.0)) == 1.0


def test_a_clipped_mean_leaves_hot_pixels_out(rng):
    values = rng.standard_normal(10_000)
    values[:200] = 1000.0
    assert abs(clipped_mean(values)) < 0.05


def test_the_level_of_a_frame_leaves_nothing(rng):
    frames = rng.standard_normal((1, 2, 64, 64)) + np.array([3.0, 50.4])[None, :, None, None]
    made = around_zero(frames, WHERE, 0.0, rng)
    for fold in FOLDS:
        rows, columns = WHERE.half(fold)
        for frame in made[0]:
            assert abs(clipped_mean(frame[np.ix_(rows, columns)])) < 1e-3


@pytest.mark.parametrize("step", [1.0, 16.0])
def test_whole_codes_leave_no_fraction(rng, step):
    """After dithering, the fractions of the values are spread alike whatever the level."""
    for level in (0.1, 0.5):
        codes = step * np.rint(3.0 * rng.standard_normal((1, 1, 64, 64)) + level)
        made = around_zero(codes, WHERE, step, rng)
        fractions = np.mod(made / step, 1.0)
        counts, _ = np.histogram(fractions, 8, (0.0, 1.0))
        assert np.sum((counts - 512) ** 2 / 512) < 25  # chi2 of 7: 1 in 1,000


def test_a_mosaic_gives_its_planes_and_windows_give_the_same():
    effects = (catalogue()["read_noise"](sigma=2.0),)
    sensor = Sensor((1400, 1200), cfa=(("R", "G"), ("G", "B")))
    captures = simulate(
        NoiseModel(effects, 64.0), sensor.shape, [(OperatingPoint(25.0), 1)], sensor=sensor
    )
    where = places((700, 600))
    found = compact_frames(captures, captures.settings[0], where)
    whole = captures.settings[0].frames[0].read()
    assert found.shape == (4, 1, 512, 512)
    for plane, (row, column) in zip(found, ((0, 0), (0, 1), (1, 0), (1, 1)), strict=True):
        assert np.array_equal(plane[0], where.compact(whole[row::2, column::2]))
