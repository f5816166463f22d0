"""A simulation in shares."""

import pytest
import small_series as small

from dnanalyze.fitting.simulated import SHADING, WANTED, Job
from dnanalyze.loaders.captures import Sensor, Window

HALVES = (Window(0, 48, 0, 80), Window(48, 96, 0, 80))


@pytest.mark.parametrize("shares", [1, 2, 3, 7])
def test_shares_are_all_parts_once_and_nearly_alike(shares):
    job = Job(small.model(), Sensor(small.SHAPE), HALVES, [(p, 4) for p in small.POINTS])
    parts = [job.parts(n, shares) for n in range(shares)]
    assert sorted(p for share in parts for p in share) == job.parts()
    assert len(job.parts()) == 2 * len(small.POINTS)
    if shares == 2:
        assert [len(p) for p in parts] == [len(small.POINTS)] * 2
        for share in parts:  # either half of the field is in both shares
            assert {half for _, half in share} == {0, 1}


@pytest.mark.parametrize("settings", [4, 5, 8])
@pytest.mark.parametrize("half", [0, 1])
def test_shares_weigh_that_of_one_half_little_is_wanted(settings, half):
    points = [(p, 4) for p in (small.POINTS * 4)[:settings]]
    job = Job(small.model(), Sensor(small.SHAPE), HALVES, points, half=half)
    weight = {half: WANTED, 1 - half: SHADING}
    loads = [sum(weight[h] for _, h in job.parts(n, 2)) for n in range(2)]
    assert sum(loads) == settings * (WANTED + SHADING)
    assert abs(loads[0] - loads[1]) <= SHADING
