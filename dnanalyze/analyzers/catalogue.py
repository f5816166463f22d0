"""Every statistic by name, over all families."""

from __future__ import annotations

import difflib
from functools import cache

from dnanalyze.analyzers.families import (
    codes,
    distribution,
    level,
    lines,
    neighbours,
    shading,
    spectrum,
    tails,
    time,
    trends,
)
from dnanalyze.analyzers.families.family import Family
from dnanalyze.analyzers.statistics import StatisticInfo
from dnanalyze.errors import InputError

# in the order of reports
FAMILIES: tuple[Family, ...] = (
    level,
    distribution,
    tails,
    spectrum,
    lines,
    neighbours,
    time,
    codes,
    shading,
)


@cache
def catalogue() -> dict[str, StatisticInfo]:
    """What each statistic is, by name, in the order of reports."""
    infos = [info for family in FAMILIES for info in family.INFOS]
    return {info.name: info for info in [*infos, *trends.INFOS]}


def find(name: str) -> StatisticInfo:
    """What the statistic ``name`` is.

    Raises
    ------
    InputError
        There is none of that name; the message lists near ones, or some.
    """
    known = catalogue()
    if name in known:
        return known[name]
    near = difflib.get_close_matches(name, known, 5)
    some = f"near names: {', '.join(near)}" if near else f"valid: {', '.join(list(known)[:5])}"
    raise InputError(
        f"no statistic is called {name!r}; {some}; `dnanalyze analyze --json` lists all"
    )
