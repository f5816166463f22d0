"""The catalogue of effects in the terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from dnanalyze.digits import number
from dnanalyze.report.terminal.common import points
from dnanalyze.report.terminal.common import table as rows_of
from dnanalyze.report.words import sentence


def catalogue(console: Console, known: Mapping[str, Any]) -> None:
    """All effects along the signal chain."""
    table = Table(box=None, pad_edge=False, padding=(0, 1), show_header=False)
    table.add_column(no_wrap=True)
    table.add_column(no_wrap=True, style="dim")
    table.add_column()
    stage = None
    for kind in sorted(known.values(), key=lambda e: (e.stage, e.name)):
        if kind.stage is not stage:
            if stage is not None:
                table.add_row()
            stage = kind.stage
            table.add_row(Text(stage.name.lower().replace("_", " "), style="dim"))
        table.add_row(Text(kind.name, style="bold"), kind.varies, Text(sentence(kind.summary)))
    console.print(table)
    console.print()
    console.print(
        "fixed: the same in every frame; temporal: new in every frame; both: by its parameters; "
        "digital: acts on the codes.",
        style="dim",
    )
    console.print("`dnanalyze effects NAME` describes one effect in full.", style="dim")


def effect(console: Console, kind: Any) -> None:
    """One effect in full."""
    stage = kind.stage.name.lower().replace("_", " ")
    console.print(
        Text(kind.name, style="bold"), Text(f" {stage}, {kind.varies}", style="dim"), sep=""
    )
    for text in (sentence(kind.summary), " ".join(kind.physics.split())):
        if text:
            console.print()
            console.print(Padding(Text(text), (0, 0, 0, 2)))
    if kind.formula:
        console.print()
        console.print(Padding(Text(kind.formula, style="italic"), (0, 0, 0, 4)))
    console.print()
    rows = (
        (
            name,
            p.unit or "–",
            " | ".join(map(str, p.choices)) or "numbers, or none"
            if p.scale == "choice"
            else f"{number(p.lower)} to {number(p.upper)}",
            p.doc,
        )
        for name, p in kind.parameters().items()
    )
    rows_of(console, ("parameter", "unit", "range", "meaning"), rows, left=4)
    if kind.fingerprint:
        console.print(
            Padding(
                Text(f"Statistics that respond most: {', '.join(kind.fingerprint)}"), (0, 0, 1, 2)
            )
        )
    points(
        console,
        "Confounded with",
        [f"{k}: {v.rstrip('.')}." for k, v in kind.confused_with.items()],
    )
    points(console, "References", list(kind.references))
