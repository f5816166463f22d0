"""Means over groups against sorted pixels, and their errors against the scatter over samples."""

import numpy as np
import pytest

from dnanalyze.analyzers.estimators.groups import groups
from dnanalyze.analyzers.estimators.quantiles import Ordered
from dnanalyze.analyzers.streaming.accumulation import make_plan

SHAPE, CUTS = (128, 160), np.array([0.25, 0.5, 0.96])


def grouped(key, weight, step=0.0):
    key, weight = key.astype(np.float32), weight.astype(np.float32)
    return groups(make_plan(key), key, Ordered(key, step), weight, CUTS)


def maps(seed, step):
    """A key, on a lattice or continuous, and what grows with it."""
    rng = np.random.default_rng(seed)
    key = rng.normal(size=SHAPE)
    key = np.rint(key / step) * step if step else key
    return key, np.exp(key) * rng.gamma(2.0, 0.5, SHAPE)


def test_of_continuous_data_the_groups_are_those_of_the_sorted_pixels():
    key, weight = maps(1, 0.0)
    found = grouped(key, weight)
    ranked = weight.ravel()[np.argsort(key.ravel())]
    parts = np.split(ranked, np.rint(CUTS * ranked.size).astype(int))
    for group, part in enumerate(parts):
        assert found.pixels(group) == part.size
        assert found.mean(group) == pytest.approx(part.mean(), rel=1e-6)


def test_where_a_cut_lies_in_a_code_groups_have_their_share_of_its_mean():
    key = np.repeat([0.0, 1.0, 2.0], SHAPE[0] * SHAPE[1] // 64 * np.array([8, 48, 8]))
    weight = np.where(key == 1.0, np.arange(key.size) % 2 * 8.0, 10.0 * key)  # mean 4 at code 1
    found = grouped(key.reshape(SHAPE), weight.reshape(SHAPE), 1.0)
    # of 64 parts 8 have code 0, 48 code 1, 8 code 2; the cuts lie at 16, 32 and 61.44 parts
    assert found.pixels(0) == pytest.approx(key.size / 4)
    expected = [(8 * 4) / 16, 4.0, (24 * 4 + 5.44 * 20) / 29.44, 20.0]
    assert [found.mean(g) for g in range(4)] == pytest.approx(expected)


@pytest.mark.parametrize("step", [0.0, 0.5, 2.0])
def test_the_mean_of_a_group_scatters_as_its_error_says(step):
    count = 60
    found = [grouped(*maps(seed, step), step) for seed in range(count)]
    for group in range(CUTS.size + 1):
        means = np.array([each.mean(group) for each in found])
        errors = np.array([each.relative_error(group) for each in found])
        # 60 values give a standard deviation to 9 %; of continuous data an error takes the pixels
        # at the ends of a group for as noisy as its mean
        ratio = means.std(ddof=1) / means.mean() / errors.mean()
        assert (0.7 if step else 0.5) < ratio < (1.35 if step else 1.7)
