"""Time limit of a search."""

from __future__ import annotations

import math
from dataclasses import dataclass
from time import monotonic

from dnanalyze.errors import InputError

# Simulations between two looks at the clock, which the processes share. One of 12 million pixels
# takes 0.6 s of processor time (a crop of an IMX541, 11.5 million): an end is met within 2 s.
BATCH = 2


class TimeUp(Exception):
    """The time limit is reached; earlier results are valid."""


@dataclass(frozen=True)
class TimeLimit:
    """A time limit, checked before the simulations of a fit.

    Parameters
    ----------
    ends : float
        On the clock of `time.monotonic`, s; infinite by default.
    """

    ends: float = math.inf

    @classmethod
    def after(cls, seconds: float | None) -> TimeLimit:
        """So many seconds from now; None: no limit.

        Raises
        ------
        InputError
            Not a number above 0.
        """
        if seconds is None:
            return cls()
        if not seconds > 0:
            raise InputError(f"--budget (budget): {seconds:g}; valid: seconds above 0")
        return cls(monotonic() + seconds)

    @property
    def batch(self) -> int | None:
        """Simulations between two looks at the clock; None where there is no end."""
        return None if math.isinf(self.ends) else BATCH

    @property
    def over(self) -> bool:
        """Whether the time is up."""
        return monotonic() > self.ends

    def check(self) -> None:
        """Raise `TimeUp` once the time is up."""
        if self.over:
            raise TimeUp
