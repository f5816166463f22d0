import numpy as np
import pytest
from readout_bench import added, line_clues

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.row_fpn import RowFpn


def test_rows_scatter_by_sigma_and_stay():
    d = added(RowFpn(2.0), shape=(8192, 6))
    r = d[0, :, 0]
    np.testing.assert_allclose(d, np.broadcast_to(r[:, None], d.shape), atol=1e-4)
    assert r.var() == pytest.approx(4.0, rel=5 * np.sqrt(2 / r.size))
    assert abs(np.corrcoef(r[1:], r[:-1])[0, 1]) < 5 / np.sqrt(r.size)


def test_follows_gain_but_not_temperature():
    cold, hot, loud = (
        added(RowFpn(1.0), shape=(256, 4), point=p)[0]
        for p in (OperatingPoint(25.0, 1.0, 1.0), OperatingPoint(85.0, 9.0, 1.0),
                  OperatingPoint(25.0, 1.0, 2.0))
    )  # fmt: skip
    np.testing.assert_allclose(hot, cold, atol=1e-4)
    np.testing.assert_allclose(loud, 2 * cold, atol=1e-4)


def test_guess_from_power_on_the_axis():
    (effect,) = RowFpn.guess(line_clues("pattern_rows", 3.0 + 512 * 0.04, 3.0, shape=(256, 512)))
    assert effect.sigma == pytest.approx(0.2, rel=1e-6)
    assert RowFpn.guess(line_clues("pattern_rows", 9.0, 3.0, z=1.0)) == []
