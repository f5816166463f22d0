import numpy as np
import pytest

from dnanalyze.model import pink


def test_field_has_its_power_in_every_mode():
    white = np.random.default_rng(4).normal(size=(48, 64)).astype(np.float32)
    modes = np.abs(np.fft.fft2(pink.field(white, 1.4))) ** 2
    base = np.abs(np.fft.fft2(white)) ** 2
    rho = np.hypot(np.fft.fftfreq(64)[None, :], np.fft.fftfreq(48)[:, None])
    rho[0, 0] = 1.0
    ratio = (modes / base * rho**1.4).ravel()[1:]
    np.testing.assert_allclose(ratio, ratio.mean(), rtol=1e-2)
    assert modes[0, 0] == pytest.approx(0.0, abs=1e-4)
    share = rho.ravel()[1:] ** -1.4
    assert ratio.mean() == pytest.approx(1 / share.mean() * white.size / (white.size - 1), rel=1e-3)


@pytest.mark.parametrize("shape", [(48, 64), (47, 63)])
def test_mean_power_is_the_mean_over_all_modes(shape):
    rho = np.hypot(np.fft.fftfreq(shape[1])[None, :], np.fft.fftfreq(shape[0])[:, None])
    rho[0, 0] = np.inf
    assert pink.mean_power(shape, 1.2) == pytest.approx(np.mean(rho**-1.2))


@pytest.mark.parametrize("shape", [(16, 33), (15, 33)])
def test_raster_has_unit_variance_and_white_at_exponent_zero(shape):
    count = shape[0] * shape[1]
    weights = pink.raster_weights(count, 0.0)
    white = np.random.default_rng(5).normal(size=(400, *shape)).astype(np.float32)
    made = np.stack([pink.raster(w, weights) for w in white])
    assert made.shape == white.shape
    assert made.var() == pytest.approx(1.0, rel=5 * np.sqrt(2 / made.size))
    flat = made.reshape(400, -1)
    lag1 = np.mean(flat[:, 1:] * flat[:, :-1])
    assert abs(lag1) < 5 / np.sqrt(made.size) + 1 / count


def test_the_level_of_a_frame_has_the_power_of_its_lowest_frequency():
    weights = pink.raster_weights(64 * 64, 1.0)
    white = np.zeros((64, 64), np.float32)
    made = pink.raster(white, weights, 1.5)
    # a mode k has variance 4 w^2 over its two sides; the level is one of two such sides
    np.testing.assert_allclose(made, 1.5 * np.sqrt(2.0) * weights[0], rtol=1e-5)
    assert abs(pink.raster(white, weights).max()) == 0
