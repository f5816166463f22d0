"""The outcome of `fit` in the terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from dnanalyze.report.terminal.common import MOST_FAILURES, points, table, verdict
from dnanalyze.report.words import DIRECT, direct_rows, parameter_rows


def fit(console: Console, captures: Any, result: Any) -> None:
    """Parameters with standard errors, and what the captures do not determine."""
    from dnanalyze.report.pages.fit import headline

    verdict(console, captures, headline(result))
    parameters(console, "parameter", result)
    directly(console, result)
    points(console, "Not determined from these captures", list(result.undetermined), MOST_FAILURES)


def parameters(console: Console, title: str, result: Any) -> None:
    """Value and standard error of each, with its unit and its operating point."""
    rows, common = parameter_rows(result)
    told = any(at for *_, at in rows)
    table(
        console,
        (title, "value", "unit", *(("at",) if told else ())),
        (row if told else row[:-1] for row in rows),
    )
    if rows and common:
        console.print(f"Operating point of the parameters: {common}.", style="dim")
        console.print()


def directly(console: Console, result: Any) -> None:
    """What the frames determine without a model, beside the model's."""
    rows = direct_rows(result)
    if rows:
        table(console, ("direct measurement", *DIRECT[1:]), rows)
