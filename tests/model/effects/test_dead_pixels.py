"""Dead pixels: their share, what they keep, and the guess of their share."""

import numpy as np
import pytest
from charge_bench import HERE, LONG, WARM, MadeUpClues, flat, frames, growth

from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.effects.dead_pixels import DeadPixels
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.read_noise import ReadNoise

SHAPE = (256, 256)
PIXELS = SHAPE[0] * SHAPE[1]
FRACTION = 0.02


@pytest.mark.parametrize("point", [HERE, LONG, WARM])
def test_a_share_of_the_pixels_has_no_charge_at_any_operating_point(point):
    y = frames((flat(50.0), DeadPixels(FRACTION)), SHAPE, point=point)[0]
    dead = y == 0.0
    assert dead.mean() == pytest.approx(FRACTION, abs=4 * np.sqrt(FRACTION / PIXELS))
    np.testing.assert_array_equal(
        dead, frames((flat(50.0), DeadPixels(FRACTION)), SHAPE, first=7)[0] == 0.0
    )
    np.testing.assert_allclose(y[~dead], y[~dead][0], rtol=1e-3)


def test_they_have_offset_and_read_noise_and_no_shot_noise():
    chain = (flat(400.0), DeadPixels(FRACTION), DarkShotNoise(1.0), PixelFpn(3.0), ReadNoise(2.0))
    stack = frames(chain, SHAPE, 16)
    dead = frames(chain[:2], SHAPE)[0] == 0.0
    seen = stack[:, dead]
    free = dead.sum() * 15
    assert seen.var(axis=0, ddof=1).mean() == pytest.approx(4.0, rel=4 * np.sqrt(2 / free))
    offsets = seen.mean(axis=0)
    assert offsets.std() == pytest.approx(np.hypot(3.0, 0.5), rel=4 / np.sqrt(2 * dead.sum()))
    assert abs(offsets.mean()) < 4 * 3.1 / np.sqrt(dead.sum())


def clues(fraction, delta=0.4, stands_out=("pattern_q0.001",), rise=True):
    """A log-normal dark signal with dead pixels, from the pattern's histogram."""
    rng = np.random.default_rng(5)
    level = np.array([4.0, 4.0 * (growth(1.0) if rise else 1.0)])
    pattern = [m * rng.lognormal(-(delta**2) / 2, delta, PIXELS) for m in level]
    for signal in pattern:
        signal[: round(fraction * PIXELS)] = 0.0
    seen = [np.histogram(p + rng.normal(0, 1, PIXELS), bins=400) for p in pattern]
    return MadeUpClues(
        (HERE, WARM), HERE, SHAPE, stands_out=stands_out,
        seen={"mean": 64.0 + level},
        curves={
            "pattern_hist_n": [n for n, _ in seen],
            "pattern_hist_x": [(x[:-1] + x[1:]) / 2 for _, x in seen],
        },
    )  # fmt: skip


@pytest.mark.parametrize("fraction", [1e-3, 0.01])
def test_the_guess_counts_pixels_that_do_not_rise(fraction):
    (found,) = DeadPixels.guess(clues(fraction))
    assert found.fraction == pytest.approx(fraction, rel=0.15)


def test_no_guess_without_a_sign_or_a_rise():
    assert DeadPixels.guess(clues(0.01, stands_out=())) == []
    assert DeadPixels.guess(clues(0.01, rise=False)) == []
    assert DeadPixels.guess(clues(0.0, delta=0.1)) == []
