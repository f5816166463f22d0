"""Levels of a photon transfer curve against the variances that were drawn."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.analyzers.estimators.photon_transfer import LEAST_PIXELS, transfer_points

GAIN, READ = 0.5, 4.0  # DN/e-, DN^2


def stack(frames: int, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    charge = np.exp(1.0 + rng.standard_normal((256, 256)))
    drawn = rng.poisson(charge, (frames, 256, 256))
    return 100.0 + GAIN * drawn + np.sqrt(READ) * rng.standard_normal(drawn.shape)


def points(frames: np.ndarray) -> np.ndarray:
    level = frames.mean(axis=0).astype(np.float32)
    variance = frames.var(axis=0, ddof=1).astype(np.float32)
    quartiles = np.quantile(level, (0.25, 0.5, 0.75))
    sigma = float(np.ptp(quartiles)) / 1.349
    return transfer_points(level, variance, float(quartiles[1]), sigma, len(frames))


@pytest.mark.parametrize("frames", [2, 4, 8, 20])
def test_variance_is_that_of_shot_and_read_noise_at_every_level(frames):
    """Within 4 standard errors and the 3 % by which unlike variances bias the midmean."""
    found = points(stack(frames))
    expected = READ + GAIN * (found[:, 0] - 100.0)
    off = np.abs(found[:, 1] - expected)
    clear = found[:, 3] > 100
    assert clear.sum() >= 4
    assert np.all(off[clear] < 4 * found[clear, 2] + 0.03 * expected[clear])


def test_telegraph_noise_in_a_tenth_of_the_pixels_moves_it_little():
    frames = stack(8)
    plain = points(frames)
    rng = np.random.default_rng(3)
    blinks = rng.random((256, 256)) < 0.1
    frames[:, blinks] += 30.0 * (rng.random((8, int(blinks.sum()))) < 0.5)
    first = points(frames)[0]
    assert first[1] < 1.15 * plain[0, 1]


def test_few_pixels_of_a_level_are_none():
    frames = stack(4)
    frames[:, 0, :LEAST_PIXELS] += 5000.0
    frames[:, 1, : LEAST_PIXELS - 1] += 50000.0
    found = points(frames)
    assert found[:, 0].max() == pytest.approx(5100.0, rel=0.01)
