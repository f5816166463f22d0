"""The outcome of `describe` in the terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from dnanalyze.report import words
from dnanalyze.report.terminal.classifier import classifier_line
from dnanalyze.report.terminal.common import points, table, verdict
from dnanalyze.report.words import number, symbol, with_error


def description(console: Console, captures: Any, result: Any) -> None:
    """The sentence, the numbers, the evidence, the nearest effects, the recommended captures."""
    verdict(console, captures, words.describe_headline(result))
    if result.classification is not None:
        classifier_line(console, result.classification)
    table(console, ("structure", "value", "unit", "in the model"), number_rows(result))
    table(console, ("nearest effect", "error after", "why it fails"), nearest_rows(result))
    points(console, "Evidence", list(result.evidence))
    if result.removed:
        console.print(f"Removed from the model: {words.listing(result.removed)}.")
        console.print()
    points(console, "Further structures", result.others)
    points(console, "Recommended captures", result.next_capture)


def in_short(console: Console, result: Any) -> None:
    """The sentence alone, and how to go on with it."""
    points(console, "Structure", [words.describe_headline(result)])
    if result.effect is not None:
        console.print("`dnanalyze describe` adds it to the model.", style="dim")
        console.print()


def number_rows(result: Any) -> list[tuple[str, str, str, str]]:
    """Name, value with standard error, unit, value in the model."""
    return [
        (
            n.name,
            with_error(n.value, n.se),
            symbol(n.unit),
            with_error(n.in_model, n.se).split(" ±")[0],
        )
        for n in result.numbers
    ]


def _to_the_same_place(n: Any) -> str:
    """The value in the model to the decimal place that the standard error allows."""
    return with_error(n.in_model, n.se).split(" ±")[0]


def nearest_rows(result: Any) -> list[tuple[str, str, str]]:
    """Effect, error with it, why it fails."""
    return [(n.effect, number(n.error_after), n.why) for n in result.nearest]
