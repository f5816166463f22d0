"""The outcome of a check: its terminal text, document, table, page and figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from dnanalyze.report import check, tables
from dnanalyze.report.figures.targets import targets
from dnanalyze.report.pages.check import check_page
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.terminal.check import result as shown


def _terminal(console: Console, result: Any) -> None:
    shown(console, result.captures, result)


def _plots(result: Any) -> Mapping[str, Draw]:
    return {"targets": lambda: targets(result.checks)}


PRESENTATION = Presentation(
    _terminal,
    check.headline,
    lambda result: check.document(result.captures.name, result, None, None, result.simulation),
    tables.checks,
    lambda result: check_page(result.captures, result),
    _plots,
)
