"""Block sums against plain sums, and the error of a mean against that of independent pixels."""

import numpy as np
import pytest

from dnanalyze.analyzers.estimators.uncertainty import block_sums, map_sums, mean_error
from dnanalyze.analyzers.streaming.accumulation import make_plan


@pytest.fixture(scope="module")
def maps():
    rng = np.random.default_rng(1)
    return rng.normal(size=(2, 131, 203)).astype(np.float32)


def test_block_sums_are_those_of_the_blocks(maps):
    plan = make_plan(maps[0])
    found = block_sums(plan, lambda a, b: a * b, *maps)
    product = (maps[0] * maps[1]).astype(float)
    rows, columns = plan.row_edges, plan.column_edges
    assert found.shape == plan.block_pixels.shape
    for r in range(found.shape[0]):
        for c in range(found.shape[1]):
            block = product[rows[r] : rows[r + 1], columns[c] : columns[c + 1]]
            assert found[r, c] == pytest.approx(block.sum(), rel=1e-12, abs=1e-12)


def test_error_of_a_mean_is_that_of_independent_pixels(maps):
    plan = make_plan(maps[0])
    error = mean_error(plan, map_sums(plan, maps[0]))
    # 31 degrees of freedom for rows and as many for columns: a relative error of at most .18
    assert error == pytest.approx(maps[0].std() / np.sqrt(maps[0].size), rel=5 * 0.18)
