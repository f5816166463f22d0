"""Whether frames show what a case claims: the truth of the suite, measured with NumPy alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from third_party.case import Point
from third_party.measures import OVER_POINTS, STATISTICS


@dataclass(frozen=True)
class Measured:
    """A claim and what the frames show."""

    statistic: str
    low: float
    high: float
    value: float

    @property
    def holds(self) -> bool:
        """Whether the value lies within the claim."""
        return self.low <= self.value <= self.high

    def __str__(self) -> str:
        return f"{self.statistic} {self.value:.4g}, claimed {self.low:.4g} to {self.high:.4g}"


def measure(
    stacks: Mapping[Point, np.ndarray], claims: Sequence[Mapping[str, Any]]
) -> list[Measured]:
    """Every claim of a case against its frames."""
    series = [stacks[p] for p in sorted(stacks)]
    found = []
    for c in claims:
        name = c["statistic"]
        if name in OVER_POINTS:
            value = OVER_POINTS[name](series, **c["options"])
        else:
            value = STATISTICS[name](series[c["point"]], **c["options"])
        found.append(Measured(name, c["low"], c["high"], value))
    return found
