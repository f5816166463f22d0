"""The EMVA 1288 quantities in the terminal: the sensor first, then every operating point."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rich.console import Console

from dnanalyze.report import emva

MOST_POINTS, MOST_GROUPS = 24, 2
Tabulate = Callable[..., None]


def emva_tables(console: Console, found: Any, tabulate: Tabulate) -> None:
    """Tables that fit 80 columns.

    Parameters
    ----------
    console : Console
    found : Emva
    tabulate : callable
        Prints a table: (console, columns, rows, left=number of columns of words).
    """
    for group in found.groups[:MOST_GROUPS]:
        where = group.label if len(found.groups) > 1 else ""
        points = emva.ends(group)
        heads = emva.labels(points) if len(points) > 1 else ["value"]
        rows = emva.point_rows(points, emva.brief)
        tabulate(console, ("", where or "quantity", *heads), rows, left=2)
        heads = ["", "quantity", "fitted range", "value"]
        tabulate(console, heads, emva.sensor_rows(group), left=3)
    points = emva.every_point(found)
    if len(points) > 2:
        for shown, first in ((emva.LEVELS, "operating point"), (emva.SPLIT, "DSNU at")):
            columns, own = emva.table(points[:MOST_POINTS], shown, first)
            tabulate(console, columns, own)
        _more(console, len(points) - MOST_POINTS, "operating points")
    for group in found.groups[:MOST_GROUPS]:
        columns, own = emva.current_table(group)
        if len(own) > 2:
            tabulate(console, columns, own)
    _more(console, len(found.groups) - MOST_GROUPS, "groups of gain, channel or colour")


def _more(console: Console, count: int, what: str) -> None:
    if count > 0:
        console.print(f"  {count} more {what}: --report, --json or --csv", style="dim")
        console.print()


def undetermined(found: Any, measured: Any, most: int) -> Sequence[str]:
    """What is not determined: EMVA quantities first, then other statistics."""
    return [*emva.undetermined(found), *emva.missing_statistics(measured)][:most]
