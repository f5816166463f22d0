"""The outcome of `inspect` in the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from dnanalyze.report import capture
from dnanalyze.report.terminal.common import points, table
from dnanalyze.report.words import number, point_label

_MOST = 10  # lines on where the metadata were taken from


def inspection(console: Console, captures: Any, seen: Mapping[str, Any]) -> None:
    """Operating points, format, and what is missing."""
    console.print(Text(capture.one_line(captures), style="bold"))
    console.print()
    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="dim", min_width=18)
    grid.add_column()
    for key, text in (capture.facts(captures) | capture.codes(seen["codes"])).items():
        grid.add_row(key, Text(text))
    console.print(Padding(grid, (0, 0, 0, 2)))
    console.print()
    table(
        console,
        ("operating point", "temperature range", "frames"),
        (
            (point_label(p), _span(p["temperature_span_c"]), p["frames"])
            for p in seen["operating_points"]
        ),
        left=2,
    )
    if rows := capture.sources(seen):
        shown = rows if len(rows) <= _MOST else rows[: _MOST - 1]
        table(console, ("quantity", "taken from", "for example"), shown, left=3)
        if len(rows) > len(shown):
            console.print(f"  and {len(rows) - len(shown)} more sources (--json)")
            console.print()
    if seen["missing"]:
        points(console, "Missing for a full analysis", seen["missing"])
    else:
        console.print("Nothing is missing for a full analysis.")


def _span(span: Sequence[float] | None) -> str:
    """Width of the temperatures in one operating point."""
    return f"{number(span[1] - span[0], 2)} °C" if span and span[1] > span[0] else "–"
