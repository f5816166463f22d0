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


def points(frames: np.ndarray, moved: float = 0.0) -> np.ndarray:
    level = frames.mean(axis=0).astype(np.float32)
    variance = frames.var(axis=0, ddof=1).astype(np.float32)
    quartiles = np.quantile(level, (0.25, 0.5, 0.75))
    sigma = float(np.ptp(quartiles)) / 1.349
    return transfer_points(level, variance, float(quartiles[1]), sigma, len(frames), moved)


@pytest.mark.parametrize("frames", [2, 4, 8, 20])
def test_variance_is_that_of_shot_and_read_noise_at_every_level(frames):
    """Within 4 standard errors."""
    found = points(stack(frames))
    expected = READ + GAIN * (found[:, 0] - 100.0)
    off = np.abs(found[:, 1] - expected)
    clear = found[:, 3] > 100
    assert clear.sum() >= 4
    assert np.all(off[clear] < 4 * found[clear, 2])


@pytest.mark.parametrize("frames", [2, 4, 8, 20])
def test_variance_stays_a_line_where_read_noise_differs_from_pixel_to_pixel(frames):
    """Variances that spread log-normally by 1: the charge adds its own, whatever they are."""
    rng = np.random.default_rng(7)
    read = np.exp(rng.standard_normal((256, 256)))
    first = []
    for charge in (1.0, 8.0):
        drawn = rng.poisson(charge, (frames, 256, 256)).astype(float)
        drawn += np.sqrt(read) * rng.standard_normal(drawn.shape)
        first.append(points(drawn)[0])
    slope = (first[1][1] - first[0][1]) / (first[1][0] - first[0][0])
    assert slope == pytest.approx(1.0, abs=0.03)


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


@pytest.mark.parametrize("frames", [3, 6])
def test_what_moves_whole_frames_is_no_noise(frames):
    """Offsets of the frames whose variance is half of that of the noise."""
    seen = stack(frames)
    offsets = np.random.default_rng(4).standard_normal(frames)
    offsets *= np.sqrt(0.5 * READ / np.var(offsets, ddof=1))
    found = points(seen + offsets[:, None, None], 0.5 * READ)
    expected = READ + GAIN * (found[:, 0] - offsets.mean() - 100.0)
    clear = found[:, 3] > 100
    off = np.abs(found[:, 1] - expected)
    assert np.all(off[clear] < 4 * found[clear, 2] + 0.03 * expected[clear])


def test_frames_that_move_by_more_than_the_noise_have_no_points():
    offsets = np.array([-10.0, 0.0, 10.0])[:, None, None]
    assert points(stack(3) + offsets, 100.0).shape == (0, 4)


def test_moves_of_the_charge_differ_from_pixel_to_pixel():
    """Of charge spread by 0.3 that moves by about its noise: within the error."""
    rng = np.random.default_rng(5)
    charge = 400.0 * np.exp(0.3 * rng.standard_normal((128, 128)))
    factors = 1.0 + 0.04 * rng.standard_normal(6)
    seen = 100.0 + GAIN * rng.poisson(factors[:, None, None] * charge)
    level, variance, error, _ = points(seen, float(np.var(seen.mean(axis=(1, 2)), ddof=1)))[0]
    assert abs(variance - GAIN * (level - 100.0)) < 2 * error
