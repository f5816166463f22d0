"""The outcome of `check` in the terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.padding import Padding
from rich.text import Text

from dnanalyze.report import capture
from dnanalyze.report.check import excess, headline, limit, look, value
from dnanalyze.report.words import plural

MOST = 12


def result(console: Console, captures: Any, outcome: Any) -> None:
    """The verdict, then each violated target with its size and its figure."""
    if captures is not None:
        console.print(Text(capture.one_line(captures), style="dim"))
        console.print()
    style = "bold" if outcome.passed else "bold red"
    console.print(Padding(Text(headline(outcome), style=style), (0, 0, 1, 2)))
    for check in outcome.failures[:MOST]:
        console.print(Padding(Text(f"✗ {check.name}", style="bold"), (0, 0, 0, 2)))
        told = "" if check.value != check.value else f"{value(check)}, "
        console.print(Padding(Text(f"{told}{excess(check)}"), (0, 0, 0, 4)))
        text = f"limit {limit(check)}; see {look(check)}"
        console.print(Padding(Text(text, style="dim"), (0, 0, 0, 4)))
    if len(outcome.failures) > MOST:
        console.print(f"  and {len(outcome.failures) - MOST} more; --json lists all", style="dim")
    if outcome.failures:
        console.print()
        console.print(
            "`dnanalyze compare CAPTURES --model M.yaml --report R.html` shows them.", style="dim"
        )


def proposed(console: Console, captures: Any, made: Any) -> None:
    """What the new targets file contains."""
    console.print(Text(capture.one_line(captures), style="dim"))
    console.print()
    missed = [t for t in made.targets if not t.enforced]
    runs = f"{1 / made.false_failures:,.0f} runs"
    text = f"{plural(len(made.targets), 'target')}; a correct simulation fails once in {runs}"
    console.print(Padding(Text(text, style="bold"), (0, 0, 0, 2)))
    if missed:
        names = ", ".join(dict.fromkeys(str(t.statistic) for t in missed))
        text = f"Not enforced, since the model violates them now ({len(missed)}): {names}"
        console.print(Padding(Text(text), (1, 0, 0, 2)))
