"""The end of the tail of pixels that stand out: clusters thin it, a rule cuts it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import ndimage
from unfiltered import Clusters

from dnanalyze.detection import tests
from dnanalyze.detection.excess import standing_out
from dnanalyze.loaders.captures import OperatingPoint

NOISE = 3.0
SIDE = 384


def _frame(hot: np.ndarray, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.round(100 + rng.poisson(60 * hot) + NOISE * rng.standard_normal(hot.shape))


def _asked(frame: np.ndarray, reach: int, replaced: np.ndarray | None = None):
    sites = () if replaced is None else [replaced]
    out = standing_out([frame[None].astype(np.float32)], reach, NOISE, replaced=sites)
    seen = SimpleNamespace(noise=NOISE, frames=3, view="frame", point=OperatingPoint())  # hits out
    return [
        tests._end(seen, out, out.difference, "dynamic_threshold"),
        tests._end(seen, out, out.ratio, "ratio_rule"),
        tests._slope(seen, out),
    ]


@pytest.mark.parametrize("law", ["exponential", "lognormal", "power", "constant"])
@pytest.mark.parametrize(("density", "size", "radius"), [(1e-3, 3, 1), (1e-2, 5, 1), (5e-3, 7, 2)])
def test_clusters_of_any_law_thin_the_tail_no_more_sharply_than_is_allowed(
    law, density, size, radius
):
    rng = np.random.default_rng([size, radius])
    frame = _frame(5 * Clusters(density, size, radius, law).draw((SIDE, SIDE), rng), size)
    for reach in (1, 2):
        for asked in _asked(frame, reach):
            assert asked.p_value > 1e-4, asked.words


@pytest.mark.parametrize(
    ("slope", "plus", "reach", "test"),
    [(1.0, 120.0, 1, "dynamic_threshold"), (2.0, 80.0, 2, "ratio_and_threshold")],
)
def test_a_rule_cuts_it(slope, plus, reach, test):
    rng = np.random.default_rng(7)
    hot = np.where(rng.random((SIDE, SIDE)) < 0.02, rng.exponential(2.0, (SIDE, SIDE)), 0)
    frame = _frame(hot, 8)
    ring = np.ones((2 * reach + 1,) * 2, bool)
    ring[reach, reach] = False
    top = ndimage.maximum_filter(frame, footprint=ring) - 100
    sites = frame - 100 > slope * top + plus
    corrected = np.where(sites, ndimage.median_filter(frame, footprint=ring), frame)
    found = {a.test: a for a in _asked(corrected, reach, np.argwhere(sites))}[test]
    assert found.p_value < 1e-6
    assert found.effect_size > found.limit
