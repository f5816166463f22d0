"""Where the black level moves with temperature, and which temperatures need a row of their own."""

import numpy as np
import pytest

from dnanalyze.fitting.moments import Moments, black_level
from dnanalyze.fitting.start import baseline_by_moments
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.laws import value_at
from dnanalyze.thermal import arrhenius

COLD, WARM = -40.0, 0.0


def series(black, exposures):
    """Mean levels: the black level and a dark current of 3 DN/s at 0 C, .6 eV."""
    points = [OperatingPoint(t, e) for t in (COLD, WARM) for e in exposures]
    mean = [black[p.temperature_c] + 3 * p.exposure_s * arrhenius(p.temperature_c, 0, 0.6)
            for p in points]  # fmt: skip
    return points, np.array(mean)


@pytest.mark.parametrize("exposures", [(0.0, 60.0), (10.0, 60.0)])
def test_level_at_exposure_zero_of_each_temperature(exposures):
    points, mean = series({COLD: 100.0, WARM: 130.0}, exposures)
    found = black_level(points, mean, np.full(mean.size, 0.1))
    assert found.moves
    law = found.law
    for t, level in ((COLD, 100.0), (WARM, 130.0)):
        assert value_at(law, OperatingPoint(t, 60.0)) == pytest.approx(level, abs=1e-6)


def test_levels_that_agree_within_their_errors_are_one():
    points, mean = series({COLD: 100.0, WARM: 100.4}, (0.0, 60.0))
    found = black_level(points, mean, np.full(mean.size, 0.1))
    assert not found.moves
    assert found.at(20.0) == (pytest.approx(100.2), pytest.approx(0.1 / np.sqrt(2)))


def test_a_level_that_moves_is_known_where_it_was_measured():
    points, mean = series({COLD: 100.0, WARM: 130.0}, (0.0, 60.0))
    found = black_level(points, mean, np.full(mean.size, 0.1))
    assert found.at(WARM) == (130.0, 0.1)
    assert found.at(-20.0) is None
    assert found.at(None) is None


def test_one_exposure_a_temperature_tells_nothing():
    points, mean = series({COLD: 100.0, WARM: 130.0}, (60.0,))
    assert black_level(points, mean, np.full(mean.size, 0.1)) is None


def test_temperatures_beside_one_another_share_a_row():
    """Ten settings in two groups .3 C wide: two rows, which give the Arrhenius law between."""
    points = [OperatingPoint(t + d, 100.0) for t in (COLD, WARM) for d in (0.0, 0.1, 0.2, 0.3)]
    points += [OperatingPoint(-20.0, 100.0), OperatingPoint(-18.0, 100.0)]
    signal = np.array([300 * arrhenius(p.temperature_c, 0, 0.6) for p in points])
    m = Moments(points, 100.0, signal, np.ones(10), 0.04 * signal**2)
    mu = baseline_by_moments(m).get("convolved_lognormal").mu
    assert sorted(p.temperature_c for p in mu.points) == [COLD, -20.0, WARM + 0.3]
    for p in points:
        grown = np.log(arrhenius(p.temperature_c, -20.0, 0.6))
        assert mu.at(p) - mu.at(points[-2]) == pytest.approx(grown, abs=0.02)
