"""Levels against the laws of black level and dark signal."""

import numpy as np
import pytest

from dnanalyze.fitting.level_laws import beyond_laws, session_levels
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import TableLaw
from dnanalyze.thermal import arrhenius

SERIES = [OperatingPoint(t, e) for t in (-10.0, 5.0, 20.0, 35.0) for e in (0.0, 1.0, 10.0)]


def levels(points, black=100.0, rate=3.0, energy=0.6):
    return np.array(
        [
            black + rate * arrhenius(p.temperature_c, 20.0, energy) * (p.exposure_s or 0.0)
            for p in points
        ]
    )


def test_nothing_is_beyond_an_activated_signal_in_proportion_to_the_exposure_time():
    rest = beyond_laws(SERIES, levels(SERIES), np.full(len(SERIES), 0.1))
    assert np.abs(rest).max() < 1e-3


def test_a_session_of_another_black_level_is_beyond_them_and_moves_no_other():
    seen = levels(SERIES)
    seen[4] += 25.0
    rest = beyond_laws(SERIES, seen, np.full(len(SERIES), 0.1))
    assert rest[4] == pytest.approx(25.0, abs=0.5)
    assert np.abs(np.delete(rest, 4)).max() < 0.5


def test_a_signal_that_is_not_proportional_is_beyond_them():
    points = [OperatingPoint(20.0, t) for t in (0.0, 10.0, 60.0, 300.0)]
    seen = np.array([100.0, 104.0, 120.0, 190.0])  # .30 DN/s over 300 s, .33 over 60, .4 over 10
    assert np.abs(beyond_laws(points, seen, np.full(4, 0.1))).max() > 0.3


def test_a_black_level_that_moves_is_taken_as_measured():
    law = TableLaw((OperatingPoint(-10.0), OperatingPoint(35.0)), (100.0, 130.0))
    seen = levels(SERIES, 0.0) + [law.at(p) for p in SERIES]
    still = np.full(len(SERIES), 0.1)
    assert np.abs(beyond_laws(SERIES, seen, still, law)).max() < 1e-3
    assert np.abs(beyond_laws(SERIES, seen, still)).max() > 1.0


def test_gains_have_levels_of_their_own():
    both = [OperatingPoint(p.temperature_c, p.exposure_s, g) for g in (1.0, 8.0) for p in SERIES]
    seen = np.concatenate([levels(SERIES), levels(SERIES, 300.0, 24.0)])
    assert np.abs(beyond_laws(both, seen, np.full(len(both), 0.1))).max() < 1e-3


@pytest.mark.parametrize(
    "points",
    [
        [OperatingPoint()],
        [OperatingPoint(20.0), OperatingPoint(30.0)],
        [OperatingPoint(None, 0.0), OperatingPoint(None, 0.0)],
    ],
)
def test_fewer_levels_than_free_parameters_are_all_within_them(points):
    rest = beyond_laws(points, np.linspace(100.0, 110.0, len(points)), np.ones(len(points)))
    assert not rest.any()


def test_a_session_has_a_black_level_of_its_own_and_the_others_share_theirs():
    seen, noise, still = levels(SERIES), np.full(len(SERIES), 4.0), np.full(len(SERIES), 0.1)
    assert session_levels(SERIES, seen, noise, still) is None
    seen[7] -= 9.0
    law, moved = session_levels(SERIES, seen, noise, still)
    assert moved.tolist() == [i == 7 for i in range(len(SERIES))]
    assert law.at(SERIES[7]) == pytest.approx(91.0, abs=0.5)
    assert law.at(SERIES[6]) == pytest.approx(100.0, abs=0.5)
    assert session_levels(SERIES, seen, 10.0 + noise, still) is None  # within a pixel's noise


def test_a_share_of_a_large_signal_is_no_other_black_level():
    points = [OperatingPoint(t, e) for t in (-10.0, 5.0, 20.0, 35.0) for e in (0.0, 1.0, 3.0, 10.0)]
    bright = levels(points, rate=400.0)
    signal = bright - 100.0
    off = np.zeros(len(points))
    off[11] = 0.06 * signal[11]  # a thermometer .6 C off
    noise, still = np.full(len(points), 4.0), np.maximum(0.01 * signal, 0.1)
    assert off[11] > 10 * noise[11]
    assert session_levels(points, bright + off, noise, still) is None
    _, moved = session_levels(points, bright + 5.0 * off, noise, still)
    assert moved.tolist() == [i == 11 for i in range(len(points))]


def test_no_dark_signal_falls_as_the_sensor_warms():
    """A level too high at a middle temperature is another black level, not a larger dark signal."""
    points = [OperatingPoint(t, 100.0) for t in (-10.0, 5.0, 20.0, 35.0)]
    points += [OperatingPoint(t, 0.0) for t in (-10.0, 5.0, 20.0, 35.0)]
    seen = levels(points, rate=0.01)
    seen[1] += 20.0
    rest = beyond_laws(points, seen, np.full(len(points), 0.1))
    # its signal is at most that of 20 C, 1 DN; with 20 C off by as much more, it could be that of
    # 35 C, 3.2 DN: the same sum of absolute deviations, with two levels off in place of one
    assert rest[1] == pytest.approx(19.3, abs=0.2)
    assert np.abs(np.delete(rest, 1)).max() < 0.1
