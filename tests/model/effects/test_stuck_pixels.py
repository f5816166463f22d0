import numpy as np
import pytest
from readout_bench import Flat, Given, frames

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.effects.stuck_pixels import StuckPixels


def test_a_share_of_pixels_has_one_code_and_no_noise():
    y = frames(ReadNoise(2.0), StuckPixels(0.01, 4000.0), count=4, shape=(256, 256))
    dead = y.std(axis=0) == 0
    n = dead.size
    assert dead.mean() == pytest.approx(0.01, abs=5 * np.sqrt(0.01 / n))
    assert np.all(y[:, dead] == 4000.0)
    assert abs(y[:, ~dead].mean() - 64.0) < 5 * 2 / np.sqrt(4 * n)


def test_same_pixels_at_any_temperature_gain_and_level():
    places = [
        frames(Flat(level), StuckPixels(0.01), point=point)[0] == 0
        for level, point in (
            (5.0, OperatingPoint(25.0, 1.0, 1.0)),
            (90.0, OperatingPoint(85.0, 9.0, 4.0)),
        )
    ]
    assert np.array_equal(*places)


def test_a_greater_share_keeps_those_that_were_stuck():
    few, many = (frames(StuckPixels(f))[0] == 0 for f in (0.001, 0.01))
    assert np.all(many[few])


def test_stuck_at_any_code_is_a_third_each_at_either_end_and_between():
    y = frames(ReadNoise(2.0), StuckPixels(0.02, 1000.0, "any"), count=4, shape=(256, 256))
    stuck = y[0, y.std(axis=0) == 0]
    n = stuck.size
    five = 5 * np.sqrt(2 / 9 / n)  # sigmas of a share of a third
    assert np.mean(stuck == 0.0) == pytest.approx(1 / 3, abs=five)
    assert np.mean(stuck == 1000.0) == pytest.approx(1 / 3, abs=five)
    between = stuck[(stuck > 0) & (stuck < 1000)]
    assert between.mean() == pytest.approx(500.0, abs=5 * 1000 / np.sqrt(12 * between.size))
    assert np.array_equal(between, np.rint(between))


def test_guess_from_pixels_without_noise():
    clues = Given(
        seen={"dead_count": 66.0}, model={"dead_count": 0.0}, off={"dead_count": 8.0},
        curves={"histogram_codes": [np.array([3, 64, 1023])]},
    )  # fmt: skip
    mixed, high, low = StuckPixels.guess(clues)
    assert low.fraction == pytest.approx(66 / 65536)
    assert (low.code, high.code, mixed.code) == (3.0, 1023.0, 1023.0)
    assert (low.codes, high.codes, mixed.codes) == ("one", "one", "any")
    assert StuckPixels.guess(Given()) == []


def test_guess_of_the_code_at_which_most_dead_pixels_stand():
    clues = Given(
        seen={"dead_count": 66.0}, model={"dead_count": 0.0}, off={"dead_count": 8.0},
        curves={
            "histogram_codes": [np.array([3, 64, 1023])], "dead_codes": [np.array([140, 900, 200])],
        },
    )  # fmt: skip
    mixed, one = StuckPixels.guess(clues)
    assert (mixed.code, mixed.codes) == (900.0, "any")
    assert (one.code, one.codes) == (140.0, "one")


def test_guess_where_the_noise_is_below_a_code_and_many_pixels_never_change():
    clues = Given(
        seen={"hot_count_64": 30.0, "cold_count_8": 15.0},
        model={"hot_count_64": 10.0, "cold_count_8": 0.0},
        off={"low_spike": 9.0},
        curves={"histogram_codes": [np.array([0, 64, 4095])]},
    )
    mixed, high, low = StuckPixels.guess(clues)
    assert mixed.fraction == pytest.approx(35 / 65536)
    assert (low.code, high.code) == (0.0, 4095.0)


def test_saturated_lines_stand_at_the_code_in_every_frame():
    effect = StuckPixels(0.002, 4095.0, "any", columns=(7.0, 50.0), rows=(20.0,))
    y = frames(ReadNoise(2.0), effect, count=3, shape=(64, 80))
    assert np.all(y[:, :, [7, 50]] == 4095.0)
    assert np.all(y[:, 20] == 4095.0)
    others = np.delete(np.delete(y[0], 20, 0), [7, 50], 1)
    plain = frames(ReadNoise(2.0), StuckPixels(0.002, 4095.0, "any"), shape=(64, 80))[0]
    np.testing.assert_array_equal(others, np.delete(np.delete(plain, 20, 0), [7, 50], 1))
    window = Window(10, 40, 30, 60)
    part = frames(ReadNoise(2.0), effect, shape=(64, 80), window=window)
    np.testing.assert_array_equal(part[0], y[0][window.slices])


def test_saturated_lines_are_told_from_offset_ones():
    clues = Given(
        shape=(64, 128), whole=(128, 128),
        seen={"dead_count": 64.0 + 8, "mean": 100.0, "temporal_noise_core": 3.0},
        model={"dead_count": 0.0}, off={"dead_count": 8.0},
        curves={"dead_codes": [np.array([4095.0])]},
        standing_out={"columns": [[7, 15.0, 0, 128], [9, 5.0, 0, 128], [11, 15.0, 40, 128]]},
    )  # fmt: skip
    (found,) = StuckPixels.guess(clues)
    assert (found.columns, found.rows, found.code) == ((7.0,), (), 4095.0)
    assert found.fraction == pytest.approx(8 / 8192)
    clues.seen["dead_count"] = 8.0  # too few for a line
    assert all(g.columns == () for g in StuckPixels.guess(clues))
