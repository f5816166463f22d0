"""What holds over temperature and exposure."""

from __future__ import annotations

from collections.abc import Sequence

from dnanalyze.analyzers.statistics import SettingStatistics, Value
from dnanalyze.loaders.captures import Sensor


def trends(settings: Sequence[SettingStatistics], sensor: Sensor) -> dict[str, Value]:
    """Dark rate over temperature and exposure."""
    return {}
