from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.classifier.descriptors import of_lines, of_pixels, of_shading, random_filters


def _named(described, word: str) -> np.ndarray:
    return described.values[:, [w == word for w in described.words]]


def test_pixels_know_nothing_of_level_rows_and_columns(rng):
    patches = rng.standard_normal((6, 16, 16)).astype(np.float32)
    lines = rng.standard_normal((6, 16, 1)) + rng.standard_normal((6, 1, 16)) + 40.0
    filters = random_filters(rng)
    plain, moved = of_pixels(patches, filters), of_pixels(patches + lines, filters)
    assert np.allclose(plain.values, moved.values, atol=2e-3)


def test_moments_and_quantiles_of_pixels(rng):
    patches = rng.exponential(2.0, (5, 16, 16))
    bare = patches - patches.mean(axis=1, keepdims=True)
    bare -= bare.mean(axis=2, keepdims=True)
    found = of_pixels(patches, random_filters(rng))
    assert np.allclose(_named(found, "standard deviation")[:, 0], bare.std(axis=(1, 2)), rtol=1e-4)
    assert np.allclose(_named(found, "upper tail")[:, 1], bare.max(axis=(1, 2)), rtol=1e-4)
    unit = bare / bare.std(axis=(1, 2), keepdims=True)
    kurtosis = (unit**4).mean(axis=(1, 2))
    assert np.allclose(_named(found, "excess kurtosis")[:, 0], kurtosis, rtol=1e-3)


def test_neighbours_of_smoothed_noise(rng):
    white = rng.standard_normal((200, 16, 17))
    smooth = (white[:, :, 1:] + white[:, :, :-1]) / np.sqrt(2)
    found = of_pixels(smooth, random_filters(rng))
    along = _named(found, "correlation of neighbouring pixels (along the row)")[:, 0]
    down = _named(found, "correlation of neighbouring pixels (along the column)")[:, 0]
    assert along.mean() == pytest.approx(0.4, abs=0.05)  # 1/2, less the removed row means
    assert abs(down.mean()) < 0.1


def test_shading_is_the_level_and_the_slopes():
    tilted = np.linspace(-1, 1, 16)[None, :, None] * np.ones((1, 16, 16)) + 3.0
    level, down, across = of_shading(tilted).values[0]
    assert level == pytest.approx(3.0)
    assert down > 0.3
    assert across == pytest.approx(0.0, abs=1e-6)


def test_lines_see_a_row_offset_and_a_period_of_two(rng):
    strips = 0.1 * rng.standard_normal((4, 64, 4))
    plain = of_lines(strips)
    strips[:, ::2] += 1.0
    moved = of_lines(strips)
    for word in ("row profile", "period of two rows"):
        assert _named(moved, word)[:, 0].min() > 3 * _named(plain, word)[:, 0].max()
