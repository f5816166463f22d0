import math

import numpy as np
import pytest

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model import bounds, fingerprints
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.guesses import evidence

POINTS = (OperatingPoint(25.0), OperatingPoint(65.0))


class Two:
    """Two settings; what is not given is absent."""

    points = POINTS
    reference = POINTS[0]
    shape = (100, 200)

    def __init__(self, measured=None, simulated=None, z=None, curves=None):
        self._values = measured or {}, simulated or {}, z or {}
        self._curves = curves or {}

    def _get(self, kind, name):
        return np.broadcast_to(np.asarray(self._values[kind].get(name, np.nan), float), 2)

    def measured(self, name):
        return self._get(0, name)

    def simulated(self, name):
        return self._get(1, name)

    def z(self, name):
        return self._get(2, name)

    def curve(self, name, setting):
        return self._curves[name][setting]


def test_a_sign_is_one_setting_beyond_the_level_in_the_right_direction():
    clues = Two(z={"a": [0.0, 3.0], "b": [-4.0, np.nan]})
    assert evidence.shows(clues, ["a"])
    assert not evidence.shows(clues, ["a"], -1)
    assert evidence.shows(clues, ["b"], -1)
    assert evidence.shows(clues, ["b"], 0)
    assert not evidence.shows(clues, ["absent"])


def test_line_sigma_inverts_the_power_of_line_offsets():
    names = fingerprints.named("pattern_rows", fingerprints.LINE_BANDS)
    clues = Two(dict.fromkeys(names, 4.0 + 200 * 0.09), dict.fromkeys(names, 4.0))
    assert evidence.line_sigma(clues, "pattern_rows", 200) == pytest.approx(0.3)


def test_white_line_sigma_is_that_of_the_bands_that_tell_it():
    """A line of a pattern raises one band by 50 DN^2 and its error 100 times."""
    names = fingerprints.named("pattern_rows", fingerprints.LINE_BANDS)
    white = 200 * 0.09
    excess = dict(zip(names, (white, white - 50.0, white, white), strict=True))
    errors = dict(zip(names, (1.0, 100.0, 1.0, 1.0), strict=True))
    clues = Two(
        {n: 4.0 + e for n, e in excess.items()},
        dict.fromkeys(names, 4.0),
        {n: excess[n] / errors[n] for n in names},
    )
    assert evidence.white_line_sigma(clues, "pattern_rows", 200) == pytest.approx(0.3, rel=1e-3)
    assert evidence.line_sigma(clues, "pattern_rows", 200) < 0.29


def test_mean_power_leaves_absent_bands_out():
    power = np.array([[np.nan], [1.0], [2.0], [3.0]])
    expected = (0.08 * 1 + 0.2 * 2 + 0.2 * 3) / 0.48
    assert evidence.mean_power(power)[0] == pytest.approx(expected)


def test_typical_values():
    assert evidence.typical(np.array([np.nan, 1.0, 3.0])) == 2.0
    assert evidence.typical(np.array([np.nan])) == 0.0
    assert evidence.typical_positive(np.array([-1.0, -2.0, 5.0])) == 5.0
    assert evidence.typical_positive(np.array([-1.0])) == 0.0


def test_power_law_and_band_centres():
    f = np.array([fingerprints.centre(b) for b in fingerprints.BANDS])
    assert f[0] == pytest.approx(math.sqrt(0.002 * 0.01))
    constant, alpha = evidence.power_law(f, 3.0 * f**-1.2, np.ones(f.size))
    assert (constant, alpha) == pytest.approx((3.0, 1.2))
    assert evidence.power_law(f, -f, np.ones(f.size)) == (0.0, 0.0)


def test_absent_curves_are_none():
    clues = Two(curves={"x": [np.array([1.0]), np.array([])]}, z={"a": [1.0, -9.0]})
    assert evidence.curve(clues, "x", 0) is not None
    assert evidence.curve(clues, "x", 1) is None
    assert evidence.curve(clues, "y", 0) is None
    assert evidence.strongest(clues, ["a"]) == 1
    assert evidence.strongest(clues, ["absent"]) is None


def test_bounded():
    assert bounds.bounded(ReadNoise, "sigma", 0.0) == 1e-3
    assert bounds.bounded(ReadNoise, "sigma", 2.0) == 2.0


def test_the_quietest_setting_is_the_least_noisy_of_those_whose_codes_change():
    assert evidence.quietest(np.array([0.05, 0.4, 0.35, 3.0])) == 2
    assert (
        evidence.quietest(np.array([np.nan, 0.0, 0.2, 0.1])) == 3
    )  # none changes often: the least
    assert evidence.quietest(np.array([np.nan, np.nan])) == 0
