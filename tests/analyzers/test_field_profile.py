"""Means of blocks, rows and columns of large fields."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.analyzers.field_profile import BLOCK, CLIPPED, field_profile


def frames(count, shape=(96, 160), sigma=2.0):
    rng = np.random.default_rng(3)
    return [rng.normal(100.0, sigma, shape) for _ in range(count)]


def test_means_are_those_of_the_mean_frame():
    seen = frames(3)
    mean = np.mean(seen, axis=0)
    found = field_profile(seen)
    blocks = mean.reshape(3, BLOCK, 5, BLOCK).mean(axis=(1, 3))
    np.testing.assert_allclose(found.blocks, blocks, atol=0.01)
    np.testing.assert_allclose(found.rows, mean.mean(axis=1), atol=0.02)
    np.testing.assert_allclose(found.columns, mean.mean(axis=0), atol=0.02)
    assert found.noise == pytest.approx(2.0, rel=0.03)


def test_a_hot_pixel_counts_as_five_standard_deviations():
    (frame,) = frames(1)
    hot = frame.copy()
    hot[40, 70] = 60_000.0
    moved = field_profile([hot]).blocks[1, 2] - field_profile([frame]).blocks[1, 2]
    assert 0.0 < moved * BLOCK**2 < (CLIPPED + 4.0) * 2.0


def test_codes_of_which_most_are_equal_have_a_noise():
    rng = np.random.default_rng(5)
    frame = (rng.random((64, 64)) < 0.1).astype(np.uint16)
    assert field_profile([frame]).noise == pytest.approx(0.3, rel=0.2)


@pytest.mark.parametrize("period", [1, 2])
def test_lines_are_told_from_shading_and_the_colours_of_a_mosaic(period):
    column = np.arange(400)
    frame = np.zeros((64, 400)) + 0.05 * column + 20.0 * (column % period)
    frame[:, 77] += 3.0
    lines = field_profile([frame]).lines("columns", period)
    assert int(np.argmax(np.abs(lines))) == 77
    assert lines[77] == pytest.approx(3.0, abs=0.2)


def test_no_frame_has_no_profile():
    with pytest.raises(ValueError, match="no frames"):
        field_profile([])
