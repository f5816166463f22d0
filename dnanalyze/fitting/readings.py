"""Statistics of a capture set as arrays over its operating points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.loaders.captures import OperatingPoint


@dataclass(frozen=True)
class Readings:
    """Values by name, one a setting; the colour planes of a setting are averaged.

    Parameters
    ----------
    statistics : Statistics
    """

    statistics: Statistics

    @cached_property
    def points(self) -> list[OperatingPoint]:
        """Operating points in order."""
        return list(dict.fromkeys(s.point for s in self.statistics.settings))

    @cached_property
    def planes(self) -> list[list[SettingStatistics]]:
        """The colour planes of each point."""
        return [[s for s in self.statistics.settings if s.point == p] for p in self.points]

    @cached_property
    def frames(self) -> np.ndarray:
        """Frames of each point."""
        return np.array([p[0].frames for p in self.planes])

    def value(self, name: str) -> np.ndarray:
        """A statistic over the points; NaN where a point lacks it."""
        return np.array(
            [_mean([s.values[name].value for s in p if name in s.values]) for p in self.planes]
        )

    def error(self, name: str) -> np.ndarray:
        """Its standard error over the points."""
        return np.array(
            [_mean([s.values[name].se for s in p if name in s.values]) for p in self.planes]
        )

    def curve(self, name: str, setting: int) -> np.ndarray:
        """A curve of one point; empty where it lacks it (first colour plane)."""
        return self.planes[setting][0].curves.get(name, np.empty(0))


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else float("nan")
