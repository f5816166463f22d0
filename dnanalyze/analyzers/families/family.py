"""What a family of statistics is, and what it gives."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.statistics import StatisticInfo, Value


@dataclass(frozen=True)
class FamilyResult:
    """What a family makes of the accumulated frames.

    ``missing`` gives, for a statistic that these frames cannot tell, the reason in a sentence.
    """

    values: dict[str, Value] = field(default_factory=dict)
    curves: dict[str, np.ndarray] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)


class Family(Protocol):
    """A module of statistics."""

    @property
    def INFOS(self) -> tuple[StatisticInfo, ...]:
        """What its statistics are."""

    def finish(self, acc: Accumulated) -> FamilyResult:
        """Values with their standard errors; pure."""
