import numpy as np
import pytest
from readout_bench import Given, added, line_clues

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.row_fpn import RowFpn
from dnanalyze.model.laws import arrhenius


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


def test_a_ramp_grows_over_the_rows_and_with_temperature_but_not_with_exposure():
    effect = RowFpn(1e-4, ramp=16.0, ea_ev=0.6)
    y = added(effect, shape=(64, 32), point=OperatingPoint(25.0, 1.0, 1.0))[0]
    np.testing.assert_allclose(y, np.broadcast_to(np.arange(64)[:, None] / 4, y.shape), atol=2e-3)
    long = added(effect, shape=(64, 32), point=OperatingPoint(25.0, 100.0, 1.0))[0]
    np.testing.assert_allclose(long, y, atol=1e-3)
    warm = added(effect, shape=(64, 32), point=OperatingPoint(35.0, 1.0, 1.0))[0]
    np.testing.assert_allclose(warm, y * arrhenius(35.0, 25.0, 0.6), atol=2e-3)
    assert RowFpn(1.0).idle() == ("ramp", "ea_ev")


def test_a_ramp_is_guessed_from_the_rows_of_the_shortest_exposures():
    points = tuple(OperatingPoint(t, e) for t in (25.0, 45.0) for e in (0.0, 300.0))
    row = np.arange(256)
    rng = np.random.default_rng(8)
    profiles = []
    for p in points:
        height = -12.0 * arrhenius(p.temperature_c, 25.0, 0.7) + 5.0 * p.exposure_s
        profiles.append(height * (row / 256 - 0.5) + 0.1 * rng.standard_normal(256))
    names = [f"pattern_rows_{b}" for b in ("0_0.02", "0.02_0.1", "0.1_0.3", "0.3_0.5")]
    clues = Given(
        points=points, seen=dict.fromkeys(names, 9.0), model=dict.fromkeys(names, 8.0),
        off=dict.fromkeys(names, 9.0), profiles={"rows": profiles},
        reference=OperatingPoint(25.0, 300.0),
    )  # fmt: skip
    effect = RowFpn.guess(clues)[1]
    assert (effect.ramp, effect.ea_ev) == pytest.approx((-12.0, 0.7), rel=0.03)
