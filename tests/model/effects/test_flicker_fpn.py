import numpy as np
import pytest
from readout_bench import POINT, Flat, Given, added, frames

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.flicker_fpn import FlickerFpn

BANDS = ((0, 0.01), (0.01, 0.02), (0.02, 0.04), (0.04, 0.08), (0.08, 0.16), (0.16, 0.25),
         (0.25, 0.35), (0.35, 0.5), (0.5, 0.71))  # fmt: skip


def spectrum(field):
    """Power and radial frequency of all modes but the mean and the two axes."""
    rows, columns = field.shape
    power = np.abs(np.fft.fft2(field)) ** 2 / field.size
    u, v = np.fft.fftfreq(columns)[None, :], np.fft.fftfreq(rows)[:, None]
    off_axis = (u != 0) & (v != 0)
    return np.hypot(u, v)[off_axis], power[off_axis]


@pytest.mark.parametrize("alpha", [0.5, 1.0, 2.0])
def test_power_law_over_two_decades_off_the_axes(alpha):
    rho, power = spectrum(added(FlickerFpn(1.0, alpha), count=1, shape=(512, 768))[0])
    edges = np.geomspace(0.004, 0.4, 21)
    bins = np.digitize(rho, edges)
    mean = [power[bins == i].mean() for i in range(1, 21)]
    number = [np.sum(bins == i) for i in range(1, 21)]
    where = [rho[bins == i].mean() for i in range(1, 21)]
    slope = np.polyfit(np.log(where), np.log(mean), 1, w=np.sqrt(number))[0]
    assert slope == pytest.approx(-alpha, abs=0.05)


def test_same_slope_along_rows_and_columns():
    field = added(FlickerFpn(1.0, 1.0), count=1, shape=(512, 512))[0]
    along, across = (np.mean(np.diff(field, axis=a) ** 2) for a in (1, 0))
    assert along == pytest.approx(across, rel=0.02)


@pytest.mark.parametrize("alpha", [1.0, 2.0])
def test_rms_over_a_frame(alpha):
    shape = (64, 96)
    u, v = np.fft.fftfreq(shape[1])[None, :], np.fft.fftfreq(shape[0])[:, None]
    rho = np.hypot(u, v)
    share = np.where(rho > 0, rho, np.inf) ** -alpha
    share /= share.sum()
    spread = np.sqrt(2 * np.sum(share**2) / 40)  # a mode and its mirror are one
    variance = [added(FlickerFpn(2.0, alpha), 1, shape, seed=s).var() for s in range(40)]
    assert np.mean(variance) == pytest.approx(4.0, rel=5 * spread)


def test_fixed_and_independent_of_temperature():
    cold = added(FlickerFpn(1.0), shape=(64, 64))
    hot = added(FlickerFpn(1.0), shape=(64, 64), point=OperatingPoint(85.0, 9.0, 2.0))
    np.testing.assert_allclose(cold[0], cold[1], atol=1e-4)
    np.testing.assert_allclose(hot[0], 2 * cold[0], atol=1e-4)


def test_guess_from_masked_power():
    names = [f"pattern_psd_{a:g}_{b:g}" for a, b in BANDS]
    centres = np.array([np.sqrt(max(a, b / 5) * b) for a, b in BANDS])
    shape = (256, 256)
    u, v = np.fft.fftfreq(256)[None, :], np.fft.fftfreq(256)[:, None]
    rho = np.hypot(u, v)
    constant = 0.25 / np.mean(np.where(rho > 0, rho, np.inf) ** -1.0)
    power = constant / centres
    clues = Given(
        shape,
        seen={n: 5.0 + p for n, p in zip(names, power, strict=True)},
        model=dict.fromkeys(names, 5.0),
        off=dict.fromkeys(names, 6.0),
    )
    (effect,) = FlickerFpn.guess(clues)
    assert effect.alpha == pytest.approx(1.0, abs=0.02)
    assert effect.rms == pytest.approx(0.5, rel=0.05)
    assert FlickerFpn.guess(Given()) == []


def test_a_share_of_the_dark_signal_multiplies_it():
    shape = (64, 96)
    field = frames(Flat(1.0), FlickerFpn(0.1), count=1, shape=shape, pedestal=0.0)[0] - 1.0
    for level in (100.0, 500.0):
        scaled = FlickerFpn(0.1, form="scaled")
        made = frames(Flat(level), scaled, count=1, shape=shape, pedestal=0.0)[0]
        np.testing.assert_allclose(made, level * (1 + field), rtol=1e-4)
    assert scaled.variance(POINT) is None


def test_a_share_is_guessed_from_power_that_grows_as_the_square_of_the_signal():
    names = [f"pattern_psd_{a:g}_{b:g}" for a, b in BANDS]
    centres = np.array([np.sqrt(max(a, b / 5) * b) for a, b in BANDS])
    u, v = np.fft.fftfreq(256)[None, :], np.fft.fftfreq(256)[:, None]
    rho = np.hypot(u, v)
    constant = 0.02**2 / np.mean(np.where(rho > 0, rho, np.inf) ** -2.0)
    signal = np.array([0.0, 50.0, 400.0])
    clues = Given(
        points=tuple(OperatingPoint(t, 1.0) for t in (0.0, 30.0, 60.0)),
        seen={n: 5.0 + constant * signal**2 / c**2 for n, c in zip(names, centres, strict=True)}
        | {"mean": 64.0 + signal},
        model=dict.fromkeys(names, 5.0),
        off=dict.fromkeys(names, 6.0),
    )
    found = FlickerFpn.guess(clues)[-1]
    assert found.form == "scaled"
    assert found.alpha == pytest.approx(2.0, abs=0.02)
    assert found.rms == pytest.approx(0.02, rel=0.05)
