import numpy as np
import pytest
from readout_bench import added, line_clues

from dnanalyze.model.effects.column_noise import ColumnNoise


def test_columns_scatter_by_sigma_anew_in_every_frame():
    d = added(ColumnNoise(0.7), count=3, shape=(6, 8192))
    c = d[:, 0]
    np.testing.assert_allclose(d, np.broadcast_to(c[:, None], d.shape), atol=1e-4)
    assert c.var() == pytest.approx(0.49, rel=5 * np.sqrt(2 / c.size))
    assert np.abs(np.corrcoef(c)[np.triu_indices(3, 1)]).max() < 5 / np.sqrt(c.shape[1])


def test_guess_from_power_in_differences():
    (effect,) = ColumnNoise.guess(
        line_clues("temporal_columns", 4.0 + 128 * 0.09, 4.0, shape=(128, 256))
    )
    assert effect.sigma == pytest.approx(0.3, rel=1e-6)
    assert ColumnNoise.guess(line_clues("pattern_columns", 90.0, 4.0)) == []
