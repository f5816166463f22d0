"""Every function that takes an executor finds with it what it finds without."""

import os
import signal
from concurrent.futures import Executor, ThreadPoolExecutor

import pytest

import dnanalyze
from dnanalyze.demo import tiny

pytestmark = pytest.mark.long


def one_point(seed=1):
    """One operating point: nothing here depends on their number."""
    return tiny(seed=seed).select(lambda point: point.temperature_c == 45.0)


@pytest.fixture(scope="module")
def captures():
    return one_point()


@pytest.fixture(scope="module")
def threads():
    with ThreadPoolExecutor(2) as executor:
        yield executor


class Counted(Executor):
    """An executor that counts its tasks, and calls something before one of them."""

    def __init__(self, executor, number=0, before=lambda: None):
        self.executor, self.number, self.before, self.count = executor, number, before, 0

    def submit(self, fn, /, *args, **kwargs):
        self.count += 1
        if self.count == self.number:
            self.before()
        return self.executor.submit(fn, *args, **kwargs)


def same(one, other):
    return one.to_dataframe().equals(other.to_dataframe())


CALLS = {
    "compare": lambda c, executor: dnanalyze.compare(c, executor=executor),
    "fit": lambda c, executor: dnanalyze.fit(c, replicates=2, executor=executor),
    "refine": lambda c, executor: dnanalyze.refine(
        c, limits=dnanalyze.SearchLimits(max_effects=0), executor=executor
    ),
    "detect": lambda c, executor: dnanalyze.detect(c, executor=executor),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_function_finds_the_same_on_an_executor(captures, threads, name):
    counted = Counted(threads)
    assert same(CALLS[name](captures, counted), CALLS[name](captures, None))
    assert counted.count > 0


def test_sensors_are_measured_beside_each_other_and_ranked_the_same(captures, threads):
    both = [captures, one_point(seed=2)]
    counted, told = Counted(threads), []
    found = dnanalyze.benchmark(
        both, at=[45.0], quick=True, executor=counted, progress=lambda *now: told.append(now[2])
    )
    assert same(found, dnanalyze.benchmark(both, at=[45.0], quick=True))
    assert counted.count == 2
    assert [s.captures for s in found.sensors] == both
    assert told[-1].startswith("Sensor 2 of 2")


@pytest.mark.filterwarnings("default")  # Dask's own
def test_a_worker_of_a_cluster_that_is_killed_loses_nothing(captures):
    dask = pytest.importorskip("distributed", reason="Dask is not installed")
    with (
        dask.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        dask.Client(cluster) as client,
    ):
        workers = sorted(client.run(os.getpid).values())

        def kill():
            os.kill(workers[0], signal.SIGTERM)

        counted = Counted(client.get_executor(), 20, kill)
        assert same(CALLS["fit"](captures, counted), CALLS["fit"](captures, None))
        assert counted.count > 20
