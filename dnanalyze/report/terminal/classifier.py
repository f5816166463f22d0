"""The outcome of a classifier two-sample test in the terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from dnanalyze.report.tables import classifier_rows
from dnanalyze.report.terminal.common import points, table, verdict


def classifier_line(console: Console, result: Any) -> None:
    """Its one sentence."""
    verdict(console, None, result.sentence(), style="")


def classification(console: Console, result: Any) -> None:
    """The sentence, what tells, and the area at every operating point."""
    verdict(console, result.captures, result.sentence())
    points(console, "Descriptors that tell most", result.telling)
    columns = ("operating point", "picture", "AUC", "95 % limits", "control")
    table(console, columns, classifier_rows(result), left=2)
