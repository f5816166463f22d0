"""Noise that is coloured along the rows: its spectrum, its correlations, and its first guess."""

import numpy as np
import pytest
from readout_bench import POINT, Given, added

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.effects.serial_noise import SerialNoise

SHAPE = (256, 384)
U = np.arange(1, 193) / 384


def along(d, lag):
    return np.mean(d[:, :, lag:] * d[:, :, : d.shape[2] - lag])


def autoregressive(first, second, bands=64):
    """Power of x_j = first x_(j-1) + second x_(j-2) + e_j in bands, of mean 1."""
    u = (np.arange(bands * 16) + 0.5) / (bands * 32)
    turn = np.exp(-2j * np.pi * u)
    power = 1.0 / np.abs(1.0 - first * turn - second * turn**2) ** 2
    power = power.reshape(bands, 16).mean(axis=1)
    return tuple((power / power.mean()).tolist())


def test_its_spectrum_is_that_of_its_bands():
    bands = (0.2, 3.0, 1.0, 0.0, 0.5, 1.5, 0.3, 0.1)
    d = added(SerialNoise(2.0, bands), count=8, shape=SHAPE)
    window = np.hanning(SHAPE[1])
    modes = np.fft.rfft(d * window, axis=2)[:, :, 1:]
    power = np.mean(np.abs(modes) ** 2, axis=(0, 1)) / np.sum(window**2)
    law = np.interp(U, (np.arange(8) + 0.5) / 16, bands)
    wanted = 4.0 * law / law.mean()
    inside = U * SHAPE[1] > 3  # the window leaks from the mean, which has half of the modes
    # the window is two modes wide and rounds the corners, where the slope is .5 a mode
    assert power[inside] == pytest.approx(wanted[inside], abs=0.2, rel=5 / np.sqrt(8 * SHAPE[0]))
    assert d.var() == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize(("first", "second"), [(0.8, 0.0), (-0.5, 0.0), (0.9, -0.6)])
def test_correlations_of_an_autoregression(first, second):
    d = added(SerialNoise(1.5, autoregressive(first, second)), count=8, shape=SHAPE)
    wanted = [1.0, first / (1 - second)]
    for _ in range(5):
        wanted.append(first * wanted[-1] + second * wanted[-2])
    spread = np.sqrt(1 + 2 * np.sum(np.square(wanted[1:]))) / np.sqrt(d.size)
    found = [along(d, k) / 1.5**2 for k in range(7)]
    assert found == pytest.approx(wanted, abs=6 * spread + 0.01)  # .01: bands of 1/128 c/px


def test_rows_and_frames_are_independent_and_ends_of_a_row_too():
    d = added(SerialNoise(3.0, autoregressive(0.9, 0.0)), count=6, shape=SHAPE)
    effective = d.size * 0.1 / 1.9
    five = 5 / np.sqrt(effective)
    assert np.mean(d[:, 1:] * d[:, :-1]) / 9.0 == pytest.approx(0.0, abs=five)
    assert np.mean(d[1:] * d[:-1]) / 9.0 == pytest.approx(0.0, abs=five)
    rows = 6 * SHAPE[0]
    assert np.mean(d[:, :, 0] * d[:, :, -1]) / 9.0 == pytest.approx(0.0, abs=5 / np.sqrt(rows))
    assert np.var(d[:, :, :8]) == pytest.approx(np.var(d[:, :, 180:188]), rel=0.2)


def test_follows_the_gain_unless_it_is_added_after_it():
    loud = OperatingPoint(25.0, 1.0, 3.0)
    one, three = (added(SerialNoise(2.0), shape=(128, 128), point=p) for p in (POINT, loud))
    after = added(SerialNoise(2.0, added="after"), shape=(128, 128), point=loud)
    five = 5 / np.sqrt(2 * one.size * 0.1)  # a low pass at a tenth of the band
    assert three.std() / one.std() == pytest.approx(3.0, rel=five)
    assert after.std() == pytest.approx(one.std(), rel=five)
    assert SerialNoise(0.4).variance(POINT) == pytest.approx(0.16)


@pytest.mark.parametrize("bands", [(0.0, 0.0), (1.0, -0.1), (1.0,) * 300])
def test_bands_that_are_no_spectrum_are_refused(bands):
    with pytest.raises(InputError, match=r"serial_noise\.bands: \d+ numbers; valid: up to 256"):
        SerialNoise(1.0, bands)


def clues(excess, white=4.0, off=8.0, part="temporal", **more):
    name = f"{part}_horizontal_spectrum"
    model = np.full(U.size, white)
    curves = {name: [model + excess], f"model {name}": [model]}
    return Given(SHAPE, off={"temporal_corr_10": off}, curves=curves, **more)


@pytest.mark.parametrize("part", ["temporal", "frame"])
def test_guess_of_a_raised_band(part):
    raised = 6.0 * np.exp(-(((U - 0.2) / 0.04) ** 2) / 2) - 0.5
    (found,) = SerialNoise.guess(clues(raised, part=part))
    assert found.sigma**2 == pytest.approx(np.mean(raised + 0.5), rel=0.02)
    power = np.array(found.bands) * found.sigma**2
    assert power == pytest.approx((raised + 0.5).reshape(32, 6).mean(axis=1), abs=0.02)


def test_no_guess_without_a_sign_or_a_spectrum():
    assert SerialNoise.guess(clues(np.linspace(2.0, 0.0, U.size), off=0.5)) == []
    assert SerialNoise.guess(clues(np.zeros(U.size))) == []
    name = "temporal_horizontal_spectrum"
    few = Given(
        (64, 64), off={"temporal_corr_10": 9.0},
        curves={name: [np.ones(32)], f"model {name}": [np.ones(32)]},
    )  # fmt: skip
    assert SerialNoise.guess(few) == []


def test_white_noise_makes_room_for_it():
    factor, shift = SerialNoise(3.0).nuisance_bias("read_noise.sigma", "DN", 5.0)
    assert (factor, shift) == (pytest.approx(0.8), 0.0)
    assert SerialNoise(3.0).nuisance_bias("pixel_fpn.sigma", "DN", 5.0) == (1.0, 0.0)
    assert SerialNoise(3.0).nuisance_bias("read_noise.sigma", "DN") == (1.0, 0.0)
