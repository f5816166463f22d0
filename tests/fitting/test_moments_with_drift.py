"""What a fit begins with where whole frames move up and down."""

import numpy as np
import pytest

from dnanalyze.demo import VirtualSensor, generate
from dnanalyze.fitting.design import design
from dnanalyze.fitting.moments import (
    FAINTEST,
    Moments,
    moments,
    most_signal,
    pedestal_guess,
    with_faint,
)
from dnanalyze.fitting.problem import fit_problem
from dnanalyze.fitting.readings import Readings
from dnanalyze.fitting.start import FAINT, SEEN, baseline_by_moments
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.thermal import arrhenius

POINTS = [OperatingPoint(t, 0.1, 1.0) for t in (5.0, 15.0, 25.0, 35.0, 45.0)]
DARK_E = np.array([2.0 * arrhenius(p.temperature_c, 25.0, 0.6) for p in POINTS])


def temporal(drift: float) -> np.ndarray:
    """Of shot noise of 1 DN/e- and 3 DN of read noise, where frames walk up and down; DN^2."""
    sensor = VirtualSensor(1.0, 3.0, 1.0, 20.0, 0.2, 0.6, 100.0, 0.1)
    hidden = {"offset_drift": {"e": drift}} if drift else {}
    at = [p.temperature_c for p in POINTS]
    problem = fit_problem(design(generate(sensor, hidden, (128, 128), at, seed=5)))
    return moments(Readings(problem.measured[0]), None).temporal


def test_what_moves_whole_frames_is_no_noise_of_pixels():
    """The quartiles of five steps and noise are wider than both variances by no fixed share."""
    expected = 9.0 + DARK_E * np.exp(0.2**2 / 2) + 1 / 12
    assert temporal(0.0) == pytest.approx(expected, rel=0.03)
    assert temporal(3.0) == pytest.approx(expected, rel=0.25)
    assert temporal(20.0) == pytest.approx(expected, rel=0.05)  # each frame less its own mean


def test_of_a_slope_lost_in_drift_a_fit_finds_some():
    falling = np.array([20.0, 18.0, 16.0, 15.0, 14.0])
    made = baseline_by_moments(Moments(POINTS, 100.0, DARK_E, falling, np.ones(5)))
    assert made.get("dark_shot_noise").dn_per_e == pytest.approx(SEEN * 14.0 / DARK_E[-1])
    made = baseline_by_moments(Moments(POINTS, 100.0, DARK_E / 100.0, falling, np.ones(5)))
    assert made.get("dark_shot_noise").dn_per_e == FAINT  # hardly any charge tells no gain


def test_levels_count_by_their_errors():
    """One of five is 2 DN low by its drift, and says so."""
    mean = 100.0 + DARK_E - [0.0, 2.0, 0.0, 0.0, 0.0]
    error = np.array([0.05, 2.0, 0.05, 0.05, 0.05])
    assert pedestal_guess(POINTS, mean, None, error) == pytest.approx(
        min(100.0, mean.min()), abs=0.1
    )
    assert pedestal_guess(POINTS, 100.0 + DARK_E, None) == pytest.approx(100.0, abs=0.1)


def test_two_temperatures_begin_with_the_most_signal_that_the_faintest_may_have():
    """Charge of 4 and 30 DN: all of the pattern is of it; with other offsets it is less."""
    signal = np.array([4.0, 30.0])
    temporal, pattern = 9.0 + signal, (0.4 * signal) ** 2
    mean = 100.0 + signal
    assert most_signal(mean, temporal, pattern) == pytest.approx(4.0)
    assert most_signal(mean, temporal, pattern + 4.0) > 4.0
    points = [OperatingPoint(t, 0.5) for t in (10.0, 30.0)]
    assert pedestal_guess(points, mean, None, 0.01, 4.0) == pytest.approx(100.0)
    assert pedestal_guess(points, mean, 101.0, 0.01, 4.0) == 101.0


def test_points_that_are_no_noisier_tell_nothing_of_the_signal():
    flat = np.array([2.0, 2.0])
    assert most_signal(np.array([100.0, 101.0]), flat, flat) == FAINTEST


def test_two_points_have_a_second_begin_with_the_least_signal():
    """A series of three tells the black level, and has one."""

    def made(count: int) -> Moments:
        points = [OperatingPoint(t, 0.5) for t in (10.0, 30.0, 50.0)[:count]]
        signal = np.array([4.0, 30.0, 200.0])[:count]
        return Moments(points, 100.0, signal, 9.0 + signal, signal**2)

    most, least = with_faint(made(2))
    assert least.pedestal == pytest.approx(104.0 - FAINTEST)
    assert least.signal == pytest.approx([FAINTEST, 26.0 + FAINTEST], abs=0.01)
    assert most.pedestal + most.signal == pytest.approx(least.pedestal + least.signal, abs=0.01)
    assert len(with_faint(made(3))) == 1
