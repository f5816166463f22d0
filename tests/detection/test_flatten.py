"""What is taken away before pixels count as exchangeable."""

import numpy as np
import pytest

from dnanalyze.detection.flatten import without_tones

SHAPE = (200, 231)


def noise():
    return np.random.default_rng(5).standard_normal(SHAPE).astype(np.float32)


def wave(u, v, amplitude):
    y, x = np.ogrid[: SHAPE[0], : SHAPE[1]]
    return (amplitude * np.sin(2 * np.pi * (u * y + v * x) + 1.0)).astype(np.float32)


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def test_white_noise_has_no_tone():
    np.testing.assert_array_equal(without_tones(noise()), noise())


@pytest.mark.parametrize("amplitude", [0.5, 5.0, 500.0])
@pytest.mark.parametrize(("u", "v"), [(0.14367, 0.1754), (-0.31, 0.05), (0.0203, 0.48)])
def test_a_wave_between_two_bins_is_gone_with_its_leakage(u, v, amplitude):
    """At most 1 % of the variance of the noise is left: half of what the correlation allows."""
    rest = without_tones(noise() + wave(u, v, amplitude))
    assert rms(rest - noise()) < 0.1


def test_a_checkerboard_that_varies_has_no_sine():
    checkers = (5.0 * (-1.0) ** np.add.outer(np.arange(200), np.arange(230))).astype(np.float32)
    own = noise()[:, :230]
    assert rms(without_tones(own + checkers) - own) < 0.1


def test_several_waves_are_gone():
    waves = wave(0.14, 0.175, 5.0) + wave(-0.31, 0.05, 3.0) + wave(0.05, 0.07, 1.0)
    assert rms(without_tones(noise() + waves) - noise()) < 0.1


def test_a_broad_line_loses_what_stands_out_of_its_octave():
    """A wave whose amplitude is new in every row is none."""
    jumps = np.random.default_rng(6).standard_normal((SHAPE[0], 1)).astype(np.float32)
    broad = jumps * wave(0.0, 0.25, 4.0)
    assert rms(without_tones(noise() + broad)) < 0.5 * rms(noise() + broad)


def test_particle_tracks_leave_the_noise_as_it_is():
    """Their power at low frequencies is no line; only what a sine takes is subtracted."""
    image = noise()
    draw = np.random.default_rng(7)
    for y, x in draw.integers(10, 190, (12, 2)):
        image[y : y + 8, x : x + 3] += 400.0
    hit = image - noise() > 1.0
    rest = without_tones(image)
    assert rms((rest - noise())[~hit]) < 0.1
