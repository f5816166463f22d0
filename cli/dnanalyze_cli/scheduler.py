"""The executor of a Dask cluster, for one command."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager


@contextmanager
def executor_at(scheduler: str | None) -> Iterator[Executor | None]:
    """That of the workers of a scheduler; None without one.

    Parameters
    ----------
    scheduler : str, optional
        Address, or "local".

    Raises
    ------
    InputError
        Dask is not installed, or no scheduler answers.
    """
    if scheduler is None:
        yield None
        return
    from dnanalyze.analyzers.streaming.distributed import cluster

    with cluster(scheduler) as client:
        yield client.get_executor()
