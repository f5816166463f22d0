"""Tasks of an executor; one that it loses is done by this process."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import suppress
from typing import Any, TypeVar

Found = TypeVar("Found")


def in_order(
    executor: Executor, function: Callable[..., Found], arguments: Sequence[tuple[Any, ...]]
) -> Iterator[Found]:
    """Return what a function finds of each tuple of arguments, in their order.

    A task that fails in the executor, for a worker that was killed or an argument that does not
    travel, is done by this process, which tells its error.

    Parameters
    ----------
    executor : Executor
        Of threads or processes, or that of a Dask client.
    function : callable
        Known to another process by its name.
    arguments : sequence of tuple
        One a task.

    Yields
    ------
    object
        One a task.

    Examples
    --------
    >>> from concurrent.futures import ThreadPoolExecutor
    >>> with ThreadPoolExecutor(2) as executor:
    ...     list(in_order(executor, pow, [(2, 3), (3, 2)]))
    [8, 9]
    """
    waiting = [submitted(executor, function, *some) for some in arguments]
    for future, some in zip(waiting, arguments, strict=True):
        yield answer(future, function, *some)


def submitted(
    executor: Executor, function: Callable[..., Found], *arguments: Any
) -> Future[Found] | None:
    """The task as an executor takes it; None where it is broken or shut down."""
    try:
        return executor.submit(function, *arguments)
    except RuntimeError:
        return None


def answer(future: Future[Found] | None, here: Callable[..., Found], *arguments: Any) -> Found:
    """What a task found; where it is lost or failed, what the function finds ``here``."""
    if future is not None:
        with suppress(Exception):
            return future.result()
    return here(*arguments)
