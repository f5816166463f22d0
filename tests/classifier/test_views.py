"""Patches are cut from the pictures that a view shows."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.classifier.descriptors import random_filters
from dnanalyze.classifier.places import FOLDS, places
from dnanalyze.classifier.views import FRAME, MEAN, PAIR, VIEWS, cut, cuts, pictures_of

WHERE = places((64, 64))
BY_KEY = {view.key: view for view in VIEWS}


def marked(count: int) -> np.ndarray:
    """Pictures of which odd columns lie 1 DN above the others, 2 DN, 3 DN, ..."""
    size = np.arange(1.0, count + 1, dtype=np.float32)[:, None, None]
    return size * (np.arange(64) % 2).astype(np.float32) * np.ones((count, 64, 1), np.float32)


@pytest.mark.parametrize(
    ("key", "pictures"),
    [("frame", {FRAME: marked(4)}), ("tall", {MEAN: marked(3), PAIR: marked(8)})],
)
def test_a_patch_is_of_its_picture_and_fewer_pictures_are_taken_again(rng, key, pictures):
    where = cuts(BY_KEY[key], WHERE, max(map(len, pictures.values())), rng)
    found = cut(BY_KEY[key], pictures, WHERE, where, random_filters(rng))
    for fold in FOLDS:
        number = where.corners[fold][:, 0]
        assert len(set(number)) > 1
        for name, patches in found[fold].patches.items():
            assert np.ptp(patches, axis=(1, 2)) == pytest.approx(number % len(pictures[name]) + 1)


def test_the_pictures_of_a_stack(rng):
    stack = rng.normal(size=(1, 4, 16, 16)).astype(np.float32)
    made = pictures_of(stack)
    assert made[MEAN][1] == pytest.approx(stack[0, 1:].mean(axis=0), abs=1e-6)
    assert made[PAIR][0] == pytest.approx((stack[0, 0] - stack[0, 1]) / np.sqrt(2.0), abs=1e-6)
    assert made[PAIR][5] == pytest.approx((stack[0, 1] - stack[0, 3]) / np.sqrt(2.0), abs=1e-6)
    assert set(pictures_of(stack[:, :1])) == {FRAME, MEAN}
