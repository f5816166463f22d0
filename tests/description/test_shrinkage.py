"""Shrinkage by frequency band: the bands, the factors, and what they do to noise and structure."""

import numpy as np
import pytest

from dnanalyze.description.shrinkage import SMALLEST, bands, factors, filtered, powers, shrinkage


def test_bands_are_octaves_and_lines_have_their_own():
    which = bands((64, 64))
    assert which[0, 0] == 0
    assert which[0, 1] == which[0, 4] != which[0, 5]
    assert which[0, 9] == which[0, 16] != which[0, 17]
    assert len({which[0, 3], which[3, 0], which[3, 3]}) == 3
    assert np.bincount(which.ravel())[1:].min() == SMALLEST


def test_power_of_white_noise_is_its_variance():
    noise = [np.random.default_rng(s).normal(0, 3.0, (128, 128)) for s in range(4)]
    which = bands((128, 128))
    modes = np.bincount(which.ravel())
    told = modes > 200
    assert powers(noise, which)[told] == pytest.approx(9.0, rel=5 / np.sqrt(4 * 200))


def test_factors_are_those_of_james_and_stein():
    """A map of known signal to noise: the factor is 1 - noise / (signal + noise)."""
    found = shrinkage(np.array([9.0, 4.0, 1.01]), np.ones(3), np.array([1, 10_000, 10_000]), 4)
    assert found[0] == 0.0
    assert found[1] == pytest.approx(0.75, abs=1e-3)
    assert found[2] == 0.0  # within chance


def test_noise_is_dropped_and_structure_kept():
    rng = np.random.default_rng(5)
    chance = [rng.normal(0, 1.0, (96, 96)) for _ in range(4)]
    columns = np.tile(rng.normal(0, 1.0, 96), (96, 1))
    seen = columns + rng.normal(0, 1.0, (96, 96))
    assert not filtered(chance[0], factors(chance[0], chance[1:])).any()
    made = filtered(seen, factors(seen, chance))
    rest = made - (columns - columns.mean())
    # of 96 columns each keeps noise of 1 / 96; the lowest bands lose little more
    assert rest.var() < 3 / 96
