import numpy as np
import pytest
from readout_bench import Given, added, line_clues

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.column_fpn import ColumnFpn


def offsets(effect, **more):
    """Offsets of 8192 columns; that they are equal over rows and frames is checked on the way."""
    d = added(effect, shape=(6, 8192), **more)
    np.testing.assert_allclose(d, np.broadcast_to(d[0, 0], d.shape), atol=1e-4)
    return d[0, 0]


def test_columns_scatter_by_sigma_and_stay():
    c = offsets(ColumnFpn(2.0))
    assert c.var() == pytest.approx(4.0, rel=5 * np.sqrt(2 / c.size))
    assert abs(np.corrcoef(c[1:], c[:-1])[0, 1]) < 5 / np.sqrt(c.size)


@pytest.mark.parametrize("rho", [-0.5, 0.8])
def test_neighbours_correlate_by_rho_at_the_same_variance(rho):
    c = offsets(ColumnFpn(2.0, rho))
    independent = c.size * (1 - rho**2) / (1 + rho**2)
    assert c.var() == pytest.approx(4.0, rel=5 * np.sqrt(2 / independent))
    assert np.corrcoef(c[1:], c[:-1])[0, 1] == pytest.approx(
        rho, abs=5 * np.sqrt((1 - rho**2) / c.size)
    )


def test_follows_gain_but_not_temperature_nor_exposure():
    cold = offsets(ColumnFpn(1.0))
    hot = offsets(ColumnFpn(1.0), point=OperatingPoint(85.0, 10.0, 1.0))
    loud = offsets(ColumnFpn(1.0), point=OperatingPoint(25.0, 1.0, 4.0))
    np.testing.assert_allclose(hot, cold, atol=1e-4)
    np.testing.assert_allclose(loud, 4 * cold, atol=2e-4)


def test_guess_from_power_on_the_axis():
    (effect,) = ColumnFpn.guess(line_clues("pattern_columns", 3.0 + 256 * 0.25, 3.0))
    assert effect.sigma == pytest.approx(0.5, rel=1e-6)
    assert effect.rho == 0.0


def test_guess_of_correlated_columns():
    f = np.sqrt([0.004 * 0.02, 0.02 * 0.1, 0.1 * 0.3, 0.3 * 0.5])
    power = 256 * 0.25 * (1 - 0.6**2) / np.abs(1 - 0.6 * np.exp(2j * np.pi * f)) ** 2
    (effect,) = ColumnFpn.guess(line_clues("pattern_columns", 3.0 + power, 3.0))
    assert effect.rho == pytest.approx(0.6, abs=0.02)
    assert effect.sigma == pytest.approx(0.5, rel=0.15)


def test_no_guess_without_a_sign():
    assert ColumnFpn.guess(line_clues("pattern_columns", 9.0, 3.0, z=2.0)) == []
    assert ColumnFpn.guess(Given()) == []
