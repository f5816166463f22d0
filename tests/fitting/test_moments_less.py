"""What a fit begins with beside an effect that moves level and variances itself."""

import numpy as np
import pytest

from dnanalyze.fitting.moments import Moments, less
from dnanalyze.fitting.start import baseline_by_moments
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.dark_current_steps import DarkCurrentSteps
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.thermal import arrhenius

POINTS = [OperatingPoint(t, 0.1, 1.0) for t in (25.0, 45.0, 65.0, 85.0)]
SHAPE = 256, 256
STEPS = DarkCurrentSteps(step=40.0, mean_number=0.3, ea_ev=0.35)
GAIN, READ, OFFSETS, SPREAD = 0.8, 2.0, 1.5, 0.4


def grown(ea_ev):
    return np.array([arrhenius(p.temperature_c, POINTS[2].temperature_c, ea_ev) for p in POINTS])


def exact():
    """Moments of a sensor with steps, and the dark signal without them; DN."""
    dark = 10.0 * grown(0.65)
    level, variance = 0.3 * 40.0 * grown(0.35), 0.3 * (40.0 * grown(0.35)) ** 2
    signal = dark + level
    pattern = OFFSETS**2 + np.expm1(SPREAD**2) * dark**2 + variance
    return Moments(POINTS, 100.0, signal, READ**2 + GAIN * signal, pattern), dark


def test_the_rest_of_the_moments_is_the_sensors():
    found, dark = exact()
    rest = less(found, STEPS, SHAPE)
    np.testing.assert_allclose(rest.signal, dark)
    np.testing.assert_allclose(rest.temporal, READ**2 + GAIN * dark)
    np.testing.assert_allclose(rest.pattern, OFFSETS**2 + np.expm1(SPREAD**2) * dark**2)
    model = baseline_by_moments(rest)
    assert model.get("dark_shot_noise").dn_per_e == pytest.approx(GAIN)
    assert model.get("read_noise").sigma == pytest.approx(np.sqrt(READ**2 - 1 / 12))
    assert model.get("pixel_fpn").sigma == pytest.approx(OFFSETS)
    assert model.get("convolved_lognormal").delta == pytest.approx(SPREAD)


def test_of_what_adds_more_than_there_is_something_stays():
    found, _ = exact()
    rest = less(found, DarkCurrentSteps(step=1e4, mean_number=3.0), SHAPE)
    for moment in (rest.signal, rest.temporal, rest.pattern):
        assert (moment > 0).all()


def test_an_effect_that_does_not_tell_leaves_them_as_they_are():
    found, _ = exact()
    assert less(found, HotPixels(), SHAPE) is found
