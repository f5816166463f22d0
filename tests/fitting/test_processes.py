"""Helper processes find what this one would, and may end at any time."""

import multiprocessing
import os
import signal
import threading
import time
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
import pytest
import small_series as small

from dnanalyze.errors import InputError
from dnanalyze.fitting import processes
from dnanalyze.fitting.processes import (
    SHARED_FROM_PIXELS,
    SHARES,
    Processes,
    helpers_for,
    helpers_of,
)
from dnanalyze.fitting.simulated import Job, room, shared
from dnanalyze.loaders.captures import Window
from dnanalyze.model.effect import Effect, Stage
from dnanalyze.model.memo import Memo
from dnanalyze.model.registry import built_in
from dnanalyze.processors import cpu_count


@pytest.fixture(scope="module")
def problem():
    return small.fit_problem_of()


@contextmanager
def helped(problem):
    """The problem with one helper, and nothing simulated yet."""
    made = replace(problem, helpers=Processes(1), predictions=Memo())
    try:
        yield made
    finally:
        made.helpers.close()


def process_of(helpers):
    """The number of its only process."""
    (executor,) = helpers._executors
    return executor.submit(os.getpid).result()


def gone(number, seconds=60.0):
    """Wait until a child process is no more."""
    end = time.monotonic() + seconds
    while any(child.pid == number for child in multiprocessing.active_children()):
        assert time.monotonic() < end
        time.sleep(0.01)


def kill_and_wait(number):
    os.kill(number, signal.SIGTERM)
    gone(number)


def values(made):
    return [
        (s.point, s.plane, {n: v.value for n, v in s.values.items()})
        for half in made
        for s in half.settings
    ]


def test_a_helper_takes_its_share_until_it_is_no_more(problem, taken):
    first, second = small.model(), small.model(read_noise={"sigma": 2.5})
    expected = [values(problem.statistics(m)) for m in (first, second)]
    with helped(problem) as made:
        for model, known in zip((first, second), expected, strict=True):
            taken.clear()
            assert values(made.statistics(model)) == known
            assert len(taken) == len(small.POINTS)  # half of the parts
        kill_and_wait(process_of(made.helpers))
        for _ in range(2):
            taken.clear()
            assert values(made.statistics(first)) == expected[0]
            assert len(taken) == 2 * len(small.POINTS)


def test_helpers_end_with_what_they_were_made_for(problem):
    with helped(problem) as made:
        made.statistics(small.model())
        number = process_of(made.helpers)
    gone(number)


@dataclass(frozen=True)
class Tilt(Effect):
    """An effect of a file that no other process has read."""

    name = "tilt"
    stage = Stage.PIXEL_READ

    def apply(self, signal, site):
        return signal + np.float32(3.0)


def test_a_users_effect_is_simulated_here(problem, taken):
    plain = values(problem.statistics(small.model()))
    with helped(problem) as made:
        taken.clear()
        tilted = values(made.statistics(small.model().with_effect(Tilt())))
        assert len(taken) == 2 * len(small.POINTS)
    # the same draws, three DN higher, but for the rounding
    for (*_, before), (*_, after) in zip(plain, tilted, strict=True):
        assert after["mean"] - before["mean"] == pytest.approx(3.0, abs=0.02)


def test_others_are_shared_beside_a_users_effect(problem, taken):
    models = small.model(), small.model().with_effect(Tilt()), small.model(pixel_fpn={"sigma": 3.0})
    expected = problem.several(models)
    with helped(problem) as made:
        taken.clear()
        found = made.several(models)
    plan = problem.plan
    job = Job(models[0], plan.captures.sensor, plan.windows, plan.settings, half=0)
    share = sum(map(len, shared([job, job], 2)[-1]))
    assert len(taken) == share + len(job.parts())  # of two models, and all of the user's
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)


def test_before_it_is_asked_a_helper_simulates_every_effect(monkeypatch):
    made, whole = [], Job.statistics
    monkeypatch.setattr(
        Job, "statistics", lambda self, *more: made.append(self) or whole(self, *more)
    )
    processes.warm()
    assert {name for job in made for name in job.model.names} == set(built_in())


@pytest.mark.parametrize("wrong", [0, 1])
def test_the_error_of_either_process_is_told_and_the_next_job_is_its_own(problem, wrong):
    """Of one setting the helper takes the upper half, this process the lower."""
    windows = list(problem.plan.windows)
    windows[wrong] = Window(0, 4, 0, 4)  # too few to analyse
    plan = problem.plan
    job = Job(small.model(), plan.captures.sensor, tuple(windows), plan.settings[:1])
    with helped(problem) as made:
        with pytest.raises(InputError):
            made.helpers.statistics([job], room())
        assert values(made.statistics(small.model())) == values(problem.statistics(small.model()))


def test_helpers_are_started_only_where_there_is_much_to_do():
    assert helpers_for(SHARED_FROM_PIXELS - 1).shares == 1
    many = helpers_for(SHARED_FROM_PIXELS)
    try:
        assert many.shares == min(cpu_count(), SHARES)
    finally:
        many.close()


def test_an_executor_of_the_caller_takes_all_of_it_and_finds_the_same(problem, taken):
    first, second = small.model(), small.model(read_noise={"sigma": 2.5})
    expected = [values(problem.statistics(m)) for m in (first, second)]
    with ThreadPoolExecutor(2) as executor:
        made = replace(problem, helpers=helpers_of(executor), predictions=Memo())
        assert [values(made.statistics(m)) for m in (first, second)] == expected
        names = {t.name for t in threading.enumerate()}
    assert any(name.startswith("ThreadPoolExecutor") for name in names)
    # it is shut down: this process goes on
    assert values(made.statistics(first)) == expected[0]
    assert made.helpers.shares == 1


class Losing(Executor):
    """An executor that loses every second task, as a cluster does whose workers are killed."""

    def __init__(self):
        self.count = 0

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        self.count += 1
        if self.count % 2:
            future.set_exception(OSError("worker killed"))
        else:
            future.set_result(fn(*args, **kwargs))
        return future


def test_what_an_executor_loses_is_done_here(problem):
    model, losing = small.model(), Losing()
    made = replace(problem, helpers=helpers_of(losing), predictions=Memo())
    assert values(made.statistics(model)) == values(problem.statistics(model))
    assert losing.count == 2 * len(small.POINTS)  # no task without a part
    squares = [(n, 2) for n in range(40)]
    assert made.helpers.each(pow, squares) == [n * n for n in range(40)]
