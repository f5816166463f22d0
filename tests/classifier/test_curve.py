from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.classifier.curve import EXCHANGED, area, mean_area


def _grid(rows: int, columns: int) -> np.ndarray:
    return np.stack(np.meshgrid(range(rows), range(columns), indexing="ij"), -1).reshape(-1, 2)


def test_the_area_is_the_share_of_pairs_in_order(rng):
    measured, simulated = rng.integers(0, 9, 40), rng.integers(0, 8, 40)
    pairs = measured[:, None] - simulated[None, :]
    expected = np.mean((pairs > 0) + 0.5 * (pairs == 0))
    found = area(measured, simulated, _grid(5, 8), (5, 8))
    assert found.value == pytest.approx(expected)
    assert found.influence.sum() == pytest.approx(0.0, abs=1e-12)


def test_the_standard_error_of_independent_places(rng):
    found = [
        area(rng.standard_normal(256), rng.standard_normal(256), _grid(16, 16), (16, 16))
        for _ in range(200)
    ]
    true = np.sqrt((2 * 256 + 1) / (12 * 256**2))  # Mann and Whitney 1947
    assert np.std([a.value for a in found]) == pytest.approx(true, rel=0.15)
    stated = np.mean([a.se for a in found]) / np.sqrt(EXCHANGED)
    assert 0.95 * true < stated < 1.25 * true  # never less than any way of counting clusters


def test_places_of_one_row_count_as_one(rng):
    def drawn() -> np.ndarray:
        return np.repeat(rng.standard_normal(16), 16)

    found = [area(drawn(), drawn(), _grid(16, 16), (16, 16)) for _ in range(200)]
    scatter = np.std([a.value for a in found])
    stated = np.sqrt(np.mean([a.se**2 for a in found]) / EXCHANGED)
    assert stated == pytest.approx(scatter, rel=0.15)


def test_folds_that_exchange_training_and_test_agree_by_chance(rng):
    """Two halves whose means differ by d and e give sign(d) e and sign(e) d."""
    d, e = rng.standard_normal((2, 20_000))
    mean = (np.sign(d) * e + np.sign(e) * d) / 2
    assert np.var(mean) == pytest.approx(EXCHANGED / 2, rel=0.03)


def test_the_mean_of_areas():
    one = area(np.array([1.0]), np.array([0.0]), _grid(1, 1), (1, 2))
    two = area(np.array([0.0]), np.array([1.0]), _grid(1, 1), (1, 2))
    assert mean_area([one, two]).value == 0.5
