import numpy as np
import pytest
from readout_bench import added, line_clues

from dnanalyze.model.effects.row_noise import RowNoise


def test_rows_scatter_by_sigma_anew_in_every_frame():
    d = added(RowNoise(0.7), count=3, shape=(8192, 6))
    r = d[:, :, 0]
    np.testing.assert_allclose(d, np.broadcast_to(r[:, :, None], d.shape), atol=1e-4)
    assert r.var() == pytest.approx(0.49, rel=5 * np.sqrt(2 / r.size))
    for pair in (np.corrcoef(r)[np.triu_indices(3, 1)], [np.corrcoef(r[0, 1:], r[0, :-1])[0, 1]]):
        assert np.abs(pair).max() < 5 / np.sqrt(r.shape[1])


def test_mean_over_frames_keeps_one_over_k_of_the_power():
    r = added(RowNoise(1.0), count=8, shape=(4096, 2))[:, :, 0]
    assert r.mean(axis=0).var() == pytest.approx(1 / 8, rel=5 * np.sqrt(2 / 4096))


def test_guess_from_power_in_differences():
    (effect,) = RowNoise.guess(line_clues("temporal_rows", 4.0 + 256 * 0.49, 4.0))
    assert effect.sigma == pytest.approx(0.7, rel=1e-6)
    assert RowNoise.guess(line_clues("pattern_rows", 90.0, 4.0)) == []
