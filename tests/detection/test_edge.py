"""The line of a correction's rule, from pixels and the largest of their neighbours."""

from __future__ import annotations

import numpy as np
import pytest

from dnanalyze.detection.edge import bound_at, tightest_line


def _survivors(slope: float, bound: float, left: float = 0.001) -> np.ndarray:
    """Hot pixels with rings of noise, some hot themselves; what crosses the line is gone, but for a
    share ``left``.
    """
    rng = np.random.default_rng(3)
    n = 20_000
    hot = rng.exponential(300.0, n) + 20.0
    rings = np.abs(rng.normal(6.0, 2.0, (3, n)))
    beside = rng.random((3, n)) < 0.1
    rings = np.where(beside, rings + rng.exponential(60.0, (3, n)), rings)
    own = rings[0]
    stays = (hot <= slope * own + bound) | (rng.random(n) < left)
    return np.stack([hot, own, rings[1], rings[2]], axis=1)[stays]


@pytest.mark.parametrize(("slope", "bound"), [(7.5, 0.0), (2.0, 80.0), (3.4, 30.0)])
def test_the_line_comes_back_between_the_steps_of_the_ladder(slope, bound):
    found = tightest_line(_survivors(slope, bound), slope - 1.2, slope + 1.0)
    assert found is not None
    told = found[0] * np.array([6.0, 40.0]) + found[1]
    # some 20 survivors within 2 % of the line at either end
    assert told == pytest.approx(slope * np.array([6.0, 40.0]) + bound, rel=0.05)


def test_where_nothing_was_replaced_there_is_no_line():
    pairs = _survivors(2.0, 80.0, left=1.0)
    assert tightest_line(pairs, 1.5, 3.0) is None
    assert tightest_line(pairs[:0], 1.5, 3.0) is None
    assert bound_at(pairs, 2.0)[1] <= 0
