"""A description: its terminal text, document, table, page and figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from dnanalyze.report import documents, tables, words
from dnanalyze.report.figures.description import description as picture
from dnanalyze.report.pages.describe import describe_page
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.terminal.description import description


def _terminal(console: Console, result: Any) -> None:
    description(console, result.captures, result)


def _plots(result: Any) -> Mapping[str, Draw]:
    return {"structure": lambda: picture(result.look)}


PRESENTATION = Presentation(
    _terminal,
    words.describe_headline,
    lambda result: documents.description(result.captures.name, result),
    tables.description,
    lambda result: describe_page(result.captures, result),
    _plots,
)
