"""What lies outside the catalogue keeps its own laws too."""

import math

import numpy as np
import pytest
from demo_stacks import CALM, HOT, ROUNDING_E2, added, stack

ROWS, COLUMNS = 192, 256


def test_rings_are_fixed_and_have_their_deviation():
    d = added({"concentric_rings": {"e": 1.0, "centre": [-0.2, 0.5], "period": 9.0}})
    assert d.var() == pytest.approx(1.0, rel=0.03)
    assert np.corrcoef(d[0].ravel(), d[1].ravel())[0, 1] > 0.98


def test_reset_ramp_grows_down_the_rows():
    d = added({"reset_ramp": {"e": 1.0}}).mean(axis=0)
    checker = (-1.0) ** (np.arange(ROWS)[:, None] + np.arange(COLUMNS))
    ramp = (d * checker).mean(axis=1)
    np.testing.assert_allclose(ramp, math.sqrt(3) * np.arange(ROWS) / (ROWS - 1), atol=0.05)


def test_blob_moves():
    d = added({"moving_blob": {"e": 4.0, "radius": 0.08}}, frames=8)
    brightest = {int(np.argmax(f)) for f in d}
    assert len(brightest) > 6
    expected = 4.0 * 2 * math.pi * (0.08 * COLUMNS) ** 2  # less what lies outside the frame
    assert 0.25 * expected < d.sum(axis=(1, 2)).mean() <= 1.02 * expected


def test_quadrants_jitter_with_the_signal():
    x = stack({"quadrant_jitter": {"relative": 0.05}}, HOT, frames=60)
    quarters = x.reshape(60, 2, ROWS // 2, 2, COLUMNS // 2).mean(axis=(2, 4)).reshape(60, 4)
    jitter = (quarters - quarters.mean(axis=0)).std() / CALM.gain_dn_e / CALM.dark_e(HOT)
    assert jitter == pytest.approx(0.05, rel=5 / math.sqrt(2 * 240))
    assert abs(np.corrcoef(quarters[:, 0], quarters[:, 1])[0, 1]) < 5 / math.sqrt(60)


def test_column_modulated_noise_keeps_its_mean_square():
    x = stack({"column_modulated_noise": {"depth": 0.5, "period": 16.0}}, frames=24)
    v = x.var(axis=0, ddof=1).mean(axis=0)
    bare = stack(frames=24).var(axis=0, ddof=1).mean()
    assert v.mean() == pytest.approx(bare, rel=0.01)
    phase = np.arange(COLUMNS) % 16
    assert v[phase == 0].mean() / v[phase == 8].mean() > 4.0


def test_telegraph_columns_jump_within_a_frame():
    d = added({"column_telegraph": {"e": 1.0}})
    jumpers = np.abs(d).mean(axis=(0, 1)) > 0.5
    assert jumpers.mean() == pytest.approx(0.05, abs=5 * math.sqrt(0.05 / COLUMNS))
    assert np.abs(d[:, :, jumpers]).mean() == pytest.approx(1.0, abs=0.02)
    smooth = np.abs(np.diff(d[:, :, jumpers], axis=1)) > 1.2
    np.testing.assert_array_less(smooth.sum(axis=1), 2)


def test_shading_drifts():
    d = added({"drifting_shading": {"e": 1.0}}, frames=120)
    size = d.std(axis=(1, 2))
    assert np.mean(size**2) == pytest.approx(1.0 + ROUNDING_E2, rel=5 * math.sqrt(2 / 120))
    assert np.abs(d.mean(axis=(1, 2))).max() < 0.05


def test_pairs_share_their_noise():
    d = added({"pair_noise": {"e": 1.0}})
    first, second = d[:, ::2, ::2], d[:, 1::2, 1::2]
    assert np.corrcoef(first.ravel(), second.ravel())[0, 1] > 0.97
    assert first.var() == pytest.approx(1.0, rel=0.05)
    assert np.abs(d[:, ::2, 1::2]).max() < 1e-9
