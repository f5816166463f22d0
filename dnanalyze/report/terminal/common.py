"""What every result in the terminal is put together from; all fits 80 columns."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from io import StringIO
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from dnanalyze.report import capture, words

COLUMNS = 80
BAR = 24
MOST_FAILURES, MOST_ROWS = 6, 8


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


def verdict(console: Console, captures: Any, text: str, style: str = "bold") -> None:
    """What was captured, then the answer; without captures the answer alone."""
    if captures is not None:
        console.print(Text(capture.one_line(captures), style="dim"))
        console.print()
    console.print(Padding(Text(text, style=style), (0, 0, 0, 2)))
    console.print()


def points(console: Console, title: str, sentences: Sequence[str], most: int | None = None) -> None:
    """A heading and a numbered list of at most so many; nothing where the list is empty."""
    if not sentences:
        return
    more = 0 if most is None else max(0, len(sentences) - most)
    sentences = sentences[: len(sentences) - more]
    console.print(Text(title + (f", {more} more in --json" if more else ""), style="bold"))
    grid = Table.grid(padding=(0, 1))
    grid.add_column(justify="right", style="dim", min_width=4)
    grid.add_column()
    for place, text in enumerate(sentences, 1):
        whole = text.endswith(".")  # so is a name that begins it
        grid.add_row(f"{place}", Text(text if whole else words.sentence(text)))
    console.print(grid)
    console.print()


def table(
    console: Console, columns: Sequence[str], rows: Iterable[Sequence[Any]], left: int = 1
) -> None:
    """A table whose first ``left`` columns are words, the others numbers."""
    made = Table(
        box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1), show_edge=False, header_style="dim"
    )
    for place, name in enumerate(columns):
        made.add_column(Text(name), justify="left" if place < left else "right", overflow="fold")
    for row in rows:
        made.add_row(*(cell if isinstance(cell, Text) else Text(str(cell)) for cell in row))
    if made.row_count:
        console.print(Padding(made, (0, 0, 0, 2)))
        console.print()


def bar(share: float, style: str = "blue") -> Text:
    """A bar of up to ``BAR`` cells; even a small share shows."""
    cells = max(0.0, min(1.0, share)) * BAR
    whole = int(cells)
    part = " ▏▎▍▌▋▊▉"[int((cells - whole) * 8)] if cells < BAR else ""
    return Text(("█" * whole + part).rstrip() or "▏", style=style)
