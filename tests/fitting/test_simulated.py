"""A simulation in shares, and of a half."""

from dataclasses import replace

import numpy as np
import pytest
import small_series as small

from dnanalyze.fitting.simulated import (
    SHADING,
    SHARED_FROM_PIXELS,
    THREADS,
    WANTED,
    Job,
    shared,
)
from dnanalyze.loaders.captures import Sensor, Window

SENSORS = 40
HALVES = (Window(0, 48, 0, 80), Window(48, 96, 0, 80))


@pytest.mark.parametrize("shares", [1, 2, 3, 7])
def test_shares_are_all_parts_once_and_nearly_alike(shares):
    job = Job(small.model(), Sensor(small.SHAPE), HALVES, [(p, 4) for p in small.POINTS])
    parts = [own for (own,) in shared([job], shares)]
    assert sorted(p for share in parts for p in share) == sorted(job.parts())
    assert len(job.parts()) == 2 * len(small.POINTS)
    if shares == 2:
        assert [len(p) for p in parts] == [len(small.POINTS)] * 2
        for share in parts:  # either half of the field is in both shares
            assert {half for _, half in share} == {0, 1}


@pytest.mark.parametrize(
    ("even", "frames", "threads"), [(False, 1, THREADS), (True, 1, 1), (True, 2, THREADS)]
)
def test_threads_are_for_simulations_of_many_pixels(even, frames, threads):
    """Those of one half alone where the other is not simulated."""
    rows, columns = SHARED_FROM_PIXELS // 1000, 1000
    halves = Window(0, rows // 2, 0, columns), Window(rows // 2, rows, 0, columns)
    point = [(small.POINTS[0], frames)]
    job = Job(small.model(), Sensor((rows, columns)), halves, point, half=0, even=even)
    assert job.threads == threads


@pytest.mark.parametrize("settings", [1, 4, 5, 8])
@pytest.mark.parametrize("half", [0, 1])
@pytest.mark.parametrize("even", [False, True])
def test_shares_of_several_jobs_weigh_that_of_one_half_little_is_wanted(settings, half, even):
    points = [(p, 4) for p in (small.POINTS * 4)[:settings]]
    job = Job(small.model(), Sensor(small.SHAPE), HALVES, points, half=half, even=even)
    weight = {half: WANTED, 1 - half: SHADING}
    taken = shared([job] * 4, 2)
    loads = [sum(weight[h] for own in share for _, h in own) for share in taken]
    assert sum(loads) == 4 * settings * (WANTED + (0 if even else SHADING))
    assert abs(loads[0] - loads[1]) <= SHADING
    for number in range(4):
        assert sorted(p for share in taken for p in share[number]) == sorted(job.parts())


def test_the_mirror_image_of_a_half_shows_the_shading_of_even_fields():
    """By its law: as far from none, and as often to either side, as a half that is drawn."""
    problem, drawn = small.fit_problem_of(), {}
    rows = [k.name.startswith("shading_") and k.name[-1].isdigit() for k in problem.train.keys]
    for even in (False, True):
        problem = replace(problem, even=even)
        made = [replace(small.model(), seed=n) for n in range(SENSORS)]
        drawn[even] = np.array(problem.several(made))[:, rows]
    assert not np.array_equal(drawn[False], drawn[True])
    power = {even: np.log(np.mean(found**2, axis=0)) for even, found in drawn.items()}
    number = sum(rows)
    difference = power[True] - power[False]
    # each the logarithm of a chi square of so many sensors over their number
    assert abs(np.mean(difference)) < 5 * np.sqrt(4 / SENSORS / number)
    assert np.mean(difference**2) < (1 + 5 * np.sqrt(2 / number)) * 4 / (SENSORS - 2)
    shift = np.mean(drawn[True], axis=0) / np.std(drawn[True], axis=0, ddof=1) * np.sqrt(SENSORS)
    assert np.max(np.abs(shift)) < 5


def test_of_even_models_nothing_of_the_other_half_is_simulated(taken):
    problem = replace(small.fit_problem_of(), even=True)
    problem.fitted_z(small.model())
    assert taken == [(n, 0) for n in range(len(small.POINTS))]
    taken.clear()
    problem.coordinates(small.model())
    assert len(taken) == 2 * len(small.POINTS)
