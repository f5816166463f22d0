"""Tasks of an executor come in order, and none is lost."""

import os
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import pytest

from dnanalyze.executors import in_order

HERE = os.getpid()


def ended(number):
    """The number's square, but for one whose process ends; this one goes on."""
    if number == 2 and os.getpid() != int(os.environ["PARENT"]):
        os._exit(1)
    return number * number


def failing(number):
    raise ValueError(f"no {number}")


def test_results_are_in_the_order_of_the_arguments():
    with ThreadPoolExecutor(3) as executor:
        assert list(in_order(executor, pow, [(n, 3) for n in range(20)])) == [
            n**3 for n in range(20)
        ]


def test_a_killed_worker_loses_nothing(monkeypatch):
    monkeypatch.setenv("PARENT", str(HERE))
    with ProcessPoolExecutor(1, get_context("spawn")) as executor:
        found = list(in_order(executor, ended, [(n,) for n in range(6)]))
    assert found == [n * n for n in range(6)]


def test_an_argument_that_does_not_travel_is_used_here():
    with ProcessPoolExecutor(1, get_context("spawn")) as executor:
        assert list(in_order(executor, len, [(Untravelled(),), ((1, 2),)])) == [7, 2]


class Untravelled:
    def __len__(self):
        return 7

    def __reduce__(self):
        raise TypeError("stays")


def test_an_error_of_the_function_is_that_of_this_process():
    with ThreadPoolExecutor(1) as executor, pytest.raises(ValueError, match="no 4"):
        list(in_order(executor, failing, [(4,)]))


def test_an_executor_that_is_shut_down_is_not_asked():
    executor = ThreadPoolExecutor(1)
    executor.shutdown()
    assert list(in_order(executor, abs, [(-1,), (2,)])) == [1, 2]
