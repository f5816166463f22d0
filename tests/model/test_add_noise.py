"""Dark noise on images against the frames of `simulate`."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze import InputError, NoiseModel, OperatingPoint, add_dark_noise, simulate
from dnanalyze.model.effects.pixel_fpn import PixelFpn
from dnanalyze.model.effects.read_noise import ReadNoise

POINT = OperatingPoint(85.0, 1 / 30)
MODEL = NoiseModel((ReadNoise(2.0), PixelFpn(3.0)), 64.0, seed=4)
SCENE = np.random.default_rng(1).uniform(0.0, 4000.0, (3, 32, 40))


def test_each_image_gets_the_frame_of_its_number_without_the_black_level():
    made = add_dark_noise(SCENE, MODEL, POINT, seed=5)
    frames = simulate(MODEL, (32, 40), [(POINT, 8)]).settings[0].frames
    for number in range(3):
        expected = SCENE[number] + frames[5 + number].read() - 64.0
        np.testing.assert_allclose(made[number], expected, atol=1e-3)
        alone = add_dark_noise(SCENE[number], MODEL, POINT, seed=5 + number)
        np.testing.assert_array_equal(made[number], alone)


def test_the_fixed_pattern_stays_and_the_noise_is_new():
    dark = np.zeros((32, 40), np.uint16)
    one, two = (add_dark_noise(dark, MODEL, POINT, seed=n) for n in (0, 1))
    # 1280 pixels: a standard deviation is known to 2 %, a correlation of 9 / 13 to 1.5 %
    assert np.std(one - two) == pytest.approx(2.0 * np.sqrt(2.0), rel=0.08)
    assert np.corrcoef(one.ravel(), two.ravel())[0, 1] == pytest.approx(9 / 13, abs=0.06)
    kept = add_dark_noise(dark, MODEL, POINT, keep_pedestal=True)
    np.testing.assert_allclose(kept, one + 64.0, atol=1e-4)


@pytest.mark.parametrize(
    ("image", "seed", "words"),
    [
        (np.zeros(5), 0, "1 axes"),
        (np.zeros((2, 2), complex), 0, "complex"),
        (np.zeros((32, 40)), -1, "0 or more"),
    ],
)
def test_what_cannot_be_an_image_is_refused(image, seed, words):
    with pytest.raises(InputError, match=words):
        add_dark_noise(image, MODEL, POINT, seed=seed)
