"""A random factor of the dark current: rms, spectrum, what it scales, and its guess."""

import numpy as np
import pytest
from charge_bench import HERE, WARM, MadeUpClues, flat, frames, growth

from dnanalyze.loaders.captures import Window
from dnanalyze.model.effects.dark_shading import DarkShading
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulator import Simulator


def blocks(frame, size=16):
    rows, columns = frame.shape
    return frame.reshape(rows // size, size, columns // size, size).mean((1, 3))


def test_it_is_a_share_of_the_dark_signal_and_keeps_its_mean():
    for level in (20.0, 300.0):
        y = frames((flat(level), DarkShading(0.1)), (96, 128))[0]
        assert y.mean() == pytest.approx(level, rel=1e-3)
        assert y.std() == pytest.approx(0.1 * level, rel=1e-2)


def test_the_same_in_every_frame_and_without_read_noise_in_it():
    alone = (flat(100.0), DarkShading(0.1))
    a, b = frames(alone, (64, 64), 2)
    np.testing.assert_allclose(a, b, atol=5e-3)
    noise = frames((*alone, ReadNoise(5.0)), (64, 64))[0] - a
    assert noise.std() == pytest.approx(5.0, rel=5 / np.sqrt(2 * 64**2))


@pytest.mark.parametrize("alpha", [2.0, 3.0])
def test_its_power_falls_as_told(alpha):
    """Differences over a lag: their mean square grows as lag^(alpha - 2), alpha in 2 to 4."""
    shape, lags = (256, 256), np.array([2, 4, 8])
    truth = []
    u = np.fft.fftfreq(512)
    rho = np.hypot(u[:, None], u[None, :])
    rho[0, 0] = np.inf
    for lag in lags:
        truth.append(np.sum(rho**-alpha * 2 * (1 - np.cos(2 * np.pi * u * lag))[None, :]))
    got = np.zeros(3)
    for seed in range(6):
        f = frames((flat(1.0), DarkShading(0.1, alpha)), shape, seed=seed)[0]
        got += [np.mean((f[:, lag:] - f[:, :-lag]) ** 2) for lag in lags]
    np.testing.assert_allclose(got / got[0], np.array(truth) / truth[0], rtol=0.15)


def test_it_is_guessed_from_blocks_that_vary_with_the_level():
    rng = np.random.default_rng(2)
    dark = flat(40.0)
    levels = [40.0, 40.0 * growth(0.6)]
    shares = [frames((dark, DarkShading(0.08)), (256, 256))[0] / 40.0 - 1.0] * 2
    maps = [
        blocks(s) * d + rng.normal(0, 0.1, (16, 16)) for s, d in zip(shares, levels, strict=True)
    ]
    clues = MadeUpClues((HERE, WARM), HERE, (256, 256), stands_out=("shading_0_1",),
                        seen={"mean": levels}, curves={"block_means": maps})  # fmt: skip
    (guess,) = DarkShading.guess(clues)
    # the lowest level is not free of charge: the slope is over the rest of it
    ratio = (levels[1] ** 2 - levels[0] ** 2) / (levels[1] - levels[0]) ** 2
    assert guess.rms == pytest.approx(0.08 * np.sqrt(ratio), rel=0.1)


def test_no_guess_where_the_blocks_vary_alike_at_all_levels():
    rng = np.random.default_rng(3)
    offsets = 5.0 * rng.standard_normal((16, 16))
    clues = MadeUpClues((HERE, WARM), HERE, (256, 256), stands_out=("shading_0_1",),
                        seen={"mean": [40.0, 200.0]},
                        curves={"block_means": [offsets] * 2})  # fmt: skip
    assert DarkShading.guess(clues) == []


def test_a_large_field_is_drawn_on_a_grid_and_any_window_is_cut_out_of_it():
    shape = (48, 3000)
    model = NoiseModel((flat(1000.0), DarkShading(rms=0.1, alpha=3.0)), 0.0, HERE)
    whole = Simulator(model, shape).frame(HERE, 0)
    part = Window(7, 31, 1201, 2400)
    np.testing.assert_array_equal(Simulator(model, shape).frame(HERE, 0, part), whole[part.slices])
    # of the grid: it is linear between points 3 pixels apart, in either direction
    factor = whole / Simulator(NoiseModel((flat(1000.0),), 0.0, HERE), shape).frame(HERE, 0)
    for axis in (0, 1):
        bends = np.diff(factor.astype(np.float64), 2, axis=axis)
        between = np.arange(bends.shape[axis]) % 3 != 2
        assert np.abs(bends.compress(between, axis)).max() < 1e-5
    assert factor.mean() == pytest.approx(1.0, abs=0.01)
    assert factor.std() == pytest.approx(0.1, rel=0.05)
