"""HDR channels side by side in the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from dnanalyze.report import capture, channel_results
from dnanalyze.report.words import leading, naming, number, percent, sentence


def refinement(console: Console, captures: Any, result: Any) -> None:
    """The effects of each channel, its model error, and that of the one model of all channels."""
    _head(console, captures, channel_results.headline(result))
    for finding in result.findings:
        console.print(Padding(Text(sentence(finding)), (0, 0, 0, 2)))
    console.print()
    _table(console, channel_results.COLUMNS, channel_results.rows(result), words=3)
    console.print(f"One model of all channels: model error {number(result.error)}.")


def diagnosis(console: Console, captures: Any, found: Mapping[str, Any], verdict: str) -> None:
    """Each channel's verdict and best candidate, with the evidence for it."""
    _head(console, captures, f"{len(found)} channels, each diagnosed separately: {verdict}")
    rows = []
    for name, d in found.items():
        best = leading(d)
        rows.append(
            (
                name,
                d.verdict,
                naming(best.effect, best.confidence) if best else "–",
                number(d.error),
                number(best.error_after) if best else "–",
                percent(best.confidence) if best else "–",
            )
        )
    titles = ("channel", "verdict", "candidate", "model error", "error after", "confidence")
    _table(console, titles, rows, words=3)
    for name, d in found.items():
        if d.verdict == "missing" and (best := leading(d)):
            for text in best.evidence[:2]:
                console.print(Padding(Text(f"{name}: {sentence(text)}"), (0, 0, 0, 2)))


def _head(console: Console, captures: Any, verdict: str) -> None:
    if captures is not None:
        console.print(Text(capture.one_line(captures), style="dim"))
        console.print()
    console.print(Padding(Text(sentence(verdict), style="bold"), (0, 0, 1, 2)))


def _table(console: Console, columns: Any, rows: Any, words: int) -> None:
    table = Table(
        box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1), show_edge=False, header_style="dim"
    )
    for place, name in enumerate(columns):
        table.add_column(name, justify="left" if place < words else "right", overflow="fold")
    for row in rows:
        table.add_row(*row)
    console.print(Padding(table, (0, 0, 1, 2)))
