"""A number with its error, or why there is none."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class BenchmarkValue:
    """A number with its error; ``note`` says where it comes from, or why it is absent.

    ``one_frame``: told by single frames, so that the fixed pattern is in it.
    """

    value: float
    se: float
    note: str = ""
    one_frame: bool = False

    @property
    def known(self) -> bool:
        """Whether there is a value."""
        return math.isfinite(self.value)


ABSENT = BenchmarkValue(math.nan, math.nan, "not determined from these captures")
