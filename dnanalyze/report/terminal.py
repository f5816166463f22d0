"""Results in the terminal: the verdict, then the sections of the result; all fits 80 columns."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from io import StringIO

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
from rich.table import Table as Grid
from rich.text import Text

from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.report import capture_facts, words
from dnanalyze.report.page import Section, Table
from dnanalyze.result import Result

COLUMNS = 80
BAR = 24


def as_text(draw: Callable[[Console], None], columns: int = COLUMNS) -> str:
    """What ``draw`` prints, as plain text of so many columns.

    Parameters
    ----------
    draw : callable
        Called with a console.
    columns : int
    """
    stream = StringIO()
    draw(
        Console(
            file=stream,
            width=columns,
            color_system=None,
            highlight=False,
            legacy_windows=False,
            force_jupyter=False,
        )
    )
    lines = (line.rstrip() for line in stream.getvalue().splitlines())
    return "\n".join(lines).strip("\n")


def show(console: Console, result: Result) -> None:
    """A result: what was captured, the verdict, its sections."""
    shown = result._presentation()
    style = "bold" if getattr(result, "passed", True) else "bold red"
    head(console, getattr(result, "captures", None), shown.headline(result), style)
    print_sections(console, shown.sections(result))


def head(console: Console, captures: CaptureSet | None, verdict: str, style: str = "bold") -> None:
    """What was captured, then the answer; without captures the answer alone."""
    if captures is not None:
        console.print(Text(capture_facts.one_line(captures), style="dim"))
        console.print()
    _line(console, verdict, style)
    console.print()


def print_sections(console: Console, sections: Iterable[Section]) -> None:
    """Those that are printed, one after another."""
    for section in sections:
        if section.printed:
            _section(console, section)


def _section(console: Console, section: Section) -> None:
    if section.text:
        for text in section.text:
            _line(console, text)
        console.print()
    _points(console, section)
    for table in section.tables:
        if table.rows and not table.folded:
            _table(console, table)


def _line(console: Console, text: str, style: str = "") -> None:
    console.print(Padding(Text(text, style=style), (0, 0, 0, 2)))


def _points(console: Console, section: Section) -> None:
    """A heading and a numbered list of at most so many; nothing where the list is empty."""
    if not section.points:
        return
    more = max(0, len(section.points) - section.most)
    console.print(Text(section.title + (f", {more} more in --json" if more else ""), style="bold"))
    grid = Grid.grid(padding=(0, 1))
    grid.add_column(justify="right", style="dim", min_width=4)
    grid.add_column()
    for place, text in enumerate(section.points[: section.most], 1):
        whole = text.endswith(".")  # so is a name that begins it
        grid.add_row(f"{place}", Text(text if whole else words.sentence(text)))
    console.print(grid)
    console.print()


def _table(console: Console, table: Table) -> None:
    """The first columns are words, the others numbers; a bar follows the first column."""
    made = Grid(
        box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1), show_edge=False, header_style="dim",
        show_header=any(table.columns),
    )  # fmt: skip
    shown = slice(len(table.columns) - table.wide)
    columns = list(table.columns[shown])
    rows = [list(map(str, row[shown])) for row in table.rows]
    left = table.words
    if table.bars:
        columns.insert(1, "")
        left += 1
        for row, share in zip(rows, table.bars, strict=True):
            row.insert(1, bar(share))
    for place, name in enumerate(columns):
        made.add_column(
            Text(name),
            justify="left" if place < left else "right",
            overflow="fold",
            no_wrap=bool(table.bars) and place == 1,
        )
    for row in rows[: table.most]:
        made.add_row(*map(Text, row))
    console.print(Padding(made, (0, 0, 0, 2)))
    if len(rows) > table.most:
        _line(console, f"and {len(rows) - table.most} more: --report, --json", "dim")
    if table.note:
        _line(console, table.note, "dim")
    console.print()


def bar(share: float) -> str:
    """A bar of up to ``BAR`` cells; even a small share shows."""
    cells = max(0.0, min(1.0, share)) * BAR
    whole = int(cells)
    part = " ▏▎▍▌▋▊▉"[int((cells - whole) * 8)] if cells < BAR else ""
    return ("█" * whole + part).rstrip() or "▏"
