"""The numbers as pandas tables, for CSV files and for whoever goes on in a notebook."""

from __future__ import annotations

from functools import cache
from typing import Any

from dnanalyze.analyzers.statistics import Scale, StatisticInfo, Value
from dnanalyze.estimate import NORMAL_95
from dnanalyze.report.words import is_number

POINT = ("temperature_c", "exposure_s", "gain", "channel")


@cache
def _infos() -> dict[str, StatisticInfo]:
    from dnanalyze.analyzers.catalogue import catalogue

    return dict(catalogue())


def info(name: str) -> StatisticInfo:
    """What a statistic is; one that the registry does not know gets its bare name."""
    return _infos().get(name) or StatisticInfo(name, "", "", name.replace("_", " "))


def named(name: str) -> str:
    """A statistic in words, its name behind them; other text as it is."""
    title = info(name).title
    return f"{title} ({name})" if name in _infos() and title else name


def measured_value(scale: Scale, value: Value, repeated: bool = False) -> dict[str, float | None]:
    """A statistic with its errors in its own unit, and its standard error on its scale.

    ``low``, ``high``: interval of 95 %, symmetric on the scale. ``repeated``: whether the column of
    the repeatability is there also where this value has none.
    """
    again = value.repeatability
    low, high = scale.ends(value.value, value.se, NORMAL_95)
    return {
        "value": value.value,
        "se": scale.plain_error(value.value, value.se),
        "low": low,
        "high": high,
        "se_scaled": value.se,
        **(
            {"repeatability": None if again is None else scale.plain_error(value.value, again)}
            if repeated or again is not None
            else {}
        ),
    }


def worst(rows: list[Any], family: str | None = None, most: int = 8) -> list[Any]:
    """Rows of a comparison by the size of their discrepancy, each statistic once, worst first."""
    own = [r for r in rows if is_number(r["discrepancy"]) and family in (None, r["family"])]
    own.sort(key=lambda r: -abs(r["discrepancy"]))
    seen: dict[str, Any] = {}
    for row in own:
        seen.setdefault(row["name"], row)
    return list(seen.values())[:most]
