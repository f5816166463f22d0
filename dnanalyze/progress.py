"""How a long computation tells how far it is: one protocol for every function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol


class Progress(Protocol):
    """Called as work goes on."""

    def __call__(self, done: int, total: int | None, what: str = "", /) -> None:
        """Take note.

        Parameters
        ----------
        done : int
            Steps done.
        total : int or None
            Steps in all; None where that is not known beforehand.
        what : str
            What is under way; empty where the numbers say it.
        """


def reporter(progress: Progress | None) -> Callable[[object], None]:
    """A callable that tells each of a series of things as a step of its own."""
    done = 0

    def tell(what: object) -> None:
        nonlocal done
        if progress is not None:
            progress(done, None, what if isinstance(what, str) else "")
            done += 1

    return tell


def ignored(what: object) -> None:
    """Tell nobody."""
