"""Charge of the storage nodes: its law over rows, pixels and temperature, and the guess."""

import numpy as np
import pytest
from charge_bench import HERE, LONG, LOUD, WARM, frames, growth
from readout_bench import Given

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.storage_dark_current import StorageDarkCurrent
from dnanalyze.model.laws import TableLaw

NODE = StorageDarkCurrent(amplitude=20.0, spread=0.6, before=0.5, ea_ev=0.7)


def test_level_and_scatter_grow_in_proportion_to_the_wait():
    y = frames(NODE, (400, 4000))[0]
    wait = 20.0 * (0.5 + np.arange(400) / 400)
    relative = np.sqrt(np.expm1(0.6**2))
    np.testing.assert_allclose(y.mean(axis=1), wait, rtol=5.5 * relative / np.sqrt(4000))
    share = (y / wait[:, None]).ravel()
    assert np.log(share).std() == pytest.approx(0.6, rel=5 / np.sqrt(2 * share.size))
    assert np.log(share).mean() == pytest.approx(-0.18, abs=5 * 0.6 / np.sqrt(share.size))


def test_the_closed_form_is_the_variance_over_the_field():
    y = frames(NODE, (1000, 1000))[0]
    # the excess kurtosis of a log-normal of 0.6 over a ramp is about 10
    assert y.var() == pytest.approx(NODE.variance(HERE), rel=5 * np.sqrt(12 / y.size))


def test_a_gamma_law_has_the_same_mean_and_variance_and_twice_the_variation_for_skewness():
    gamma = StorageDarkCurrent(amplitude=20.0, spread=0.6, before=50.0, law="gamma")
    y = frames(gamma, (400, 2500))[0]
    share = y / (20.0 * (50.0 + np.arange(400) / 400))[:, None]
    relative = np.sqrt(np.expm1(0.6**2))
    assert share.mean() == pytest.approx(1.0, abs=5 * relative / 1000)
    assert share.std() == pytest.approx(relative, rel=5 * np.sqrt(3 / share.size))
    skewness = np.mean((share - 1.0) ** 3) / share.std() ** 3
    assert skewness == pytest.approx(2 * relative, rel=0.05)
    assert y.var() == pytest.approx(gamma.variance(HERE), rel=0.01)


def test_it_follows_temperature_and_gain_and_not_the_exposure():
    y = frames(NODE)[0]
    np.testing.assert_array_equal(frames(NODE, point=LONG)[0], y)
    np.testing.assert_allclose(frames(NODE, point=WARM)[0], growth(0.7) * y, rtol=1e-5)
    np.testing.assert_allclose(frames(NODE, point=LOUD)[0], 2.0 * y, rtol=1e-6)


def test_a_sensor_read_from_the_bottom_has_the_mirrored_ramp():
    up = StorageDarkCurrent(amplitude=20.0, spread=0.0, first="bottom")
    down = StorageDarkCurrent(amplitude=20.0, spread=0.0)
    np.testing.assert_array_equal(frames(up)[0], frames(down)[0][::-1])


def test_its_charge_has_shot_noise():
    chain = (StorageDarkCurrent(amplitude=400.0, spread=0.0), DarkShotNoise(dn_per_e=2.0))
    y = frames(chain, (200, 500), 8)
    variance = y.var(axis=0, ddof=1)[-20:].mean()
    mean = y[:, -20:].mean()
    assert variance == pytest.approx(2.0 * mean, rel=5 * np.sqrt(2 / (7 * 20 * 500)))


def test_an_amplitude_for_each_operating_point_has_no_energy():
    table = TableLaw((HERE, WARM), (1.0, 30.0))
    assert StorageDarkCurrent(amplitude=table).inactive_parameters() == ("ea_ev",)
    assert NODE.inactive_parameters() == ()


def blocks(amplitude, before, upward=False, floor=0.3):
    """Variance between neighbours in 32 x 16 blocks, with the scatter of 500 pixels each."""
    rng = np.random.default_rng(3)
    u = (np.arange(32) + 0.5) / 32
    u = u[::-1] if upward else u
    variance = floor + np.expm1(0.64) * (amplitude * (before + u)) ** 2
    return variance[:, None] * (1.0 + 0.05 * rng.standard_normal((32, 16)))


@pytest.mark.parametrize("upward", [False, True])
def test_the_guess_has_the_amplitude_for_a_first_row_read_at_once_or_later(upward):
    each = [blocks(2.0, 0.0, upward), blocks(2.0 * growth(0.7), 0.0, upward)]
    clues = Given(points=(HERE, WARM), reference=HERE, curves={"scatter_blocks": each},
                  off={"scatter_shading_0_1": 10.0})  # fmt: skip
    at_once, later = StorageDarkCurrent.guess(clues)
    assert (at_once.before, later.before) == (0.0, 2.0)
    assert at_once.first == ("bottom" if upward else "top")
    assert (at_once.amplitude, at_once.ea_ev) == pytest.approx((2.0, 0.7), rel=0.05)
    # the same growth of the variance: (2 b + 1) w^2
    assert at_once.amplitude**2 == pytest.approx(5.0 * later.amplitude**2)


def test_operating_points_of_another_clock_have_amplitudes_of_their_own():
    fast, slow = OperatingPoint(exposure_s=1e-4), OperatingPoint(exposure_s=4e-2)
    each = [blocks(0.5, 0.0), blocks(2.0, 0.0)]
    clues = Given(points=(fast, slow), reference=slow, curves={"scatter_blocks": each},
                  off={"scatter_shading_0_1": 10.0})  # fmt: skip
    tables = [g for g in StorageDarkCurrent.guess(clues) if isinstance(g.amplitude, TableLaw)]
    assert tables[0].amplitude.values == pytest.approx((0.5, 2.0), rel=0.05)


def test_scatter_that_is_alike_in_all_rows_is_no_sign():
    flat = {"scatter_blocks": [blocks(0.0, 0.0)]}
    assert StorageDarkCurrent.guess(Given(curves=flat, off={"scatter_shading_0_1": 10.0})) == []
    assert StorageDarkCurrent.guess(Given(curves={"scatter_blocks": [blocks(2.0, 0.0)]})) == []
