"""Pixels with more Gaussian noise: moments, repetition, and the guess from two populations."""

import numpy as np
import pytest
from charge_bench import HERE, LONG, LOUD, WARM, MadeUpClues, frames

from dnanalyze.model.effects.noisy_pixels import NoisyPixels
from dnanalyze.model.guesses.noisy_pixels import LEVELS, populations

SHAPE = (128, 128)


def test_variance_and_kurtosis_over_the_frame():
    y = frames(NoisyPixels(0.1, 3.0), SHAPE, 20)
    pixels = SHAPE[0] * SHAPE[1]
    # of a binomial number of pixels, with 20 draws each
    error = np.sqrt((0.9 / 0.1 + 2 / (0.1 * 20)) / pixels)
    assert y.var() == pytest.approx(0.1 * 9.0, rel=5 * error)
    assert np.mean(y**4) / np.mean(y**2) ** 2 == pytest.approx(3 / 0.1, rel=0.15)
    assert y.mean() == pytest.approx(0.0, abs=5 * np.sqrt(0.9 / y.size))


def test_the_same_pixels_gaussian_and_independent_from_frame_to_frame():
    y = frames(NoisyPixels(0.2, 4.0), SHAPE, 12)
    noisy = (y != 0).any(axis=0)
    assert np.array_equal(noisy, (y != 0).all(axis=0))
    z = y[:, noisy] / 4.0
    n = z.size
    assert np.mean(z**4) == pytest.approx(3.0, abs=5 * np.sqrt(96 / n))
    assert np.mean(z[1:] * z[:-1]) == pytest.approx(0.0, abs=5 / np.sqrt(n))


def test_it_follows_the_gain_alone():
    effect = NoisyPixels(0.2, 4.0)
    sizes = [frames(effect, SHAPE, point=p).std() for p in (HERE, LONG, WARM, LOUD)]
    error = 5 * np.sqrt(1 / (0.2 * SHAPE[0] * SHAPE[1]))
    assert sizes == pytest.approx(sizes[0] * np.array([1, 1, 1, 2]), rel=error)


def test_quantiles_of_two_populations_are_those_of_drawn_variances():
    rng = np.random.default_rng(4)
    ratio = np.where(rng.random(400_000) < 0.05, 9.0, 1.0)
    drawn = ratio * rng.chisquare(5, ratio.size) / 5
    np.testing.assert_allclose(
        populations(0.05, 9.0, 5), np.quantile(drawn, LEVELS) / drawn.mean(), rtol=0.03
    )


def test_they_are_guessed_from_the_quantiles():
    quantiles = dict(
        zip([f"temporal_variance_q{p:g}" for p in LEVELS], populations(0.03, 9.0, 5), strict=True)
    )
    clues = MadeUpClues(
        seen={**quantiles, "temporal_noise": 2.0, "blink_repeat": 0.3},
        stands_out=("temporal_variance_q0.99",),
        curves={"frame_means": [np.zeros(6)]},
    )
    first = NoisyPixels.guess(clues)[0]
    assert first.fraction == pytest.approx(0.03)
    assert first.sigma**2 == pytest.approx(8.0 * 4.0 / 1.24, rel=0.15)
    clues.seen["blink_repeat"] = 0.0
    assert NoisyPixels.guess(clues) == []
