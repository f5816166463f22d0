import numpy as np
import pytest
from readout_bench import Flat, Given, frames

from dnanalyze.loaders.captures import OperatingPoint
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
