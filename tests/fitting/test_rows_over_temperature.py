"""Rows of a table over temperature: as many as the span of the temperatures carries."""

import numpy as np
import pytest

from dnanalyze.fitting.moments import Moments
from dnanalyze.fitting.start import baseline_by_moments
from dnanalyze.loaders.captures import OperatingPoint


def rows(*points: tuple[float, float]) -> list[float]:
    """Temperatures of the rows of mu for points (temperature, exposure)."""
    made = [OperatingPoint(*p) for p in points]
    signal = np.array([1.0 + 10.0 * p.exposure_s for p in made])
    moments = Moments(made, 100.0, signal, 4.0 + signal, 1.0 + 0.01 * signal**2)
    mu = baseline_by_moments(moments).get("convolved_lognormal").mu
    return [p.temperature_c for p in mu.points]


@pytest.mark.parametrize(
    ("points", "wanted"),
    [
        # a short exposure tells no level of its own, and a slope between two rows would be made up
        (((-17.26, 0.12), (-17.2, 0.9), (-17.03, 0.3)), [-17.2]),
        (((-8.6, 5.0), (-7.0, 5.0)), [-8.6, -7.0]),
        (((20.0, 1.0), (21.0, 0.001)), [20.0]),
        (((20.0, 1.0), (40.0, 0.001)), [20.0, 40.0]),
    ],
)
def test_temperatures_near_each_other_have_rows_where_the_longest_exposure_was(points, wanted):
    assert rows(*points) == wanted


def test_other_exposures_of_one_temperature_share_its_row():
    assert rows((-17.2, 0.12), (-17.2, 0.9), (-17.2, 0.3)) == [-17.2]
