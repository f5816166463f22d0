from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.classifier.curve import area
from dnanalyze.classifier.descriptors import of_pixels, random_filters
from dnanalyze.classifier.network import convolutional
from dnanalyze.classifier.places import FOLDS
from dnanalyze.classifier.training import boosting, cross_fit, one_thread, went_by
from dnanalyze.classifier.views import Samples

GRID = (16, 16)


def _samples(rng: np.random.Generator, share: float) -> dict[tuple[int, int], Samples]:
    """White noise of which a share is that of the neighbour."""
    filters = random_filters(np.random.default_rng(1))
    made = {}
    for fold in FOLDS:
        white = rng.standard_normal((64, 16, 17)).astype(np.float32)
        patches = white[:, :, 1:] + share * white[:, :, :-1]
        places = np.stack(np.meshgrid(range(8), range(8), indexing="ij"), -1).reshape(-1, 2)
        described = of_pixels(patches, filters).of("frame")
        made[fold] = Samples(
            described, {"frame": patches}, 8 * np.array(fold) + places, np.ones(64, bool)
        )
    return made


def test_correlated_neighbours_are_told_and_named(rng):
    measured, simulated = _samples(rng, 0.3), _samples(rng, 0.0)
    with one_thread():
        assert cross_fit(measured, simulated, GRID, boosting, 0).area.value > 0.8
        named = went_by(measured, simulated, GRID, 0)[0][0]
    assert named == "correlation of neighbouring pixels (along the row) of the frame"


def test_like_patches_are_not_told(rng):
    with one_thread():
        found = cross_fit(_samples(rng, 0.0), _samples(rng, 0.0), GRID, boosting, 0).area
    assert abs(found.value - 0.5) < 4 * found.se


def test_a_network_tells_correlated_neighbours(rng):
    pytest.importorskip("torch")
    measured, simulated = _samples(rng, 0.3), _samples(rng, 0.0)
    fold, other = FOLDS[0], FOLDS[3]
    with one_thread():
        scores = [convolutional(measured[fold], simulated[fold], 0) for _ in range(2)]
        found = [(s(measured[other]), s(simulated[other])) for s in scores]
    assert np.allclose(found[0][0], found[1][0], rtol=1e-4, atol=1e-5)
    assert area(*found[0], measured[other].places, GRID).value > 0.7
