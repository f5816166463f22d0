"""How first guesses carry an amplitude over temperature, exposure and gain."""

from types import SimpleNamespace

import numpy as np
import pytest

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.bounds import clip
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.guesses import hints
from dnanalyze.thermal import arrhenius

REFERENCE = OperatingPoint(45.0, 2.0, 1.0)


def clues(*points: OperatingPoint, reference: OperatingPoint = REFERENCE) -> SimpleNamespace:
    return SimpleNamespace(points=points, reference=reference)


def test_thermal_fit_recovers_an_arrhenius_law_and_leaves_out_the_unknown():
    points = [OperatingPoint(t, 2.0) for t in (5.0, 25.0, 45.0, 65.0, 85.0)]
    amplitude = np.array([7.0 * arrhenius(p.temperature_c, 45.0, 0.62) for p in points])
    amplitude[[0, 2]] = np.nan, -1.0
    assert hints.thermal_fit(clues(*points), amplitude) == pytest.approx((7.0, 0.62))


def test_growth_by_arrhenius_is_one_where_a_temperature_is_not_known():
    told = clues(OperatingPoint(), OperatingPoint(65.0))
    grown = hints.thermal_growth(told, np.array([0.0, 0.6]))
    np.testing.assert_allclose(grown, [[1.0, 1.0], [1.0, arrhenius(65.0, 45.0, 0.6)]])
    unknown = clues(OperatingPoint(65.0), reference=OperatingPoint())
    assert hints.thermal_growth(unknown, np.array([0.6])) == [[1.0]]


def test_thermal_fit_without_a_range_of_temperatures_takes_the_default():
    one = clues(OperatingPoint(45.0), OperatingPoint(45.0))
    assert hints.thermal_fit(one, np.array([4.0, 9.0]), 0.4) == pytest.approx((6.9, 0.4), rel=0.1)
    # a degree apart, a ratio of 2 would be 6 eV
    near = clues(OperatingPoint(44.5), OperatingPoint(45.5))
    assert hints.thermal_fit(near, np.array([4.0, 8.0]), 0.4)[1] == 0.4
    unknown = clues(OperatingPoint(), OperatingPoint())
    assert hints.thermal_fit(unknown, np.array([4.0, 8.0]), 0.4) == (6.0, 0.4)
    assert hints.thermal_fit(one, np.array([np.nan, 0.0])) is None


def test_thermal_fit_keeps_to_the_energies_of_silicon():
    points = clues(OperatingPoint(25.0), OperatingPoint(65.0))
    assert hints.thermal_fit(points, np.array([5.0, 1.0]))[1] == 0.0
    assert hints.thermal_fit(points, np.array([1e-9, 1.0]))[1] == 1.5


def test_exposure_and_gain_are_ratios_and_unknown_where_nothing_is_collected():
    held = clues(
        OperatingPoint(25.0, 4.0, 3.0), OperatingPoint(25.0), OperatingPoint(25.0, 0.0, 1.0)
    )
    np.testing.assert_array_equal(hints.exposure_and_gain(held), [6.0, 1.0, np.nan])
    np.testing.assert_array_equal(hints.gains(held), [3.0, 1.0, 1.0])


def test_clip_keeps_values_inside_the_bounds():
    held = clip(HotPixels, fraction=2.0, scale=1e-9, ea_ev=0.5)
    assert held == {"fraction": 0.3, "scale": 1e-2, "ea_ev": 0.5}
