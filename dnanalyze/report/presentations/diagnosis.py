"""A diagnosis: its terminal text, document, table, page and figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from dnanalyze.report import documents, tables, words
from dnanalyze.report.figures.candidates import candidates
from dnanalyze.report.pages.diagnose import diagnose_page
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.terminal.diagnosis import diagnosis


def _terminal(console: Console, result: Any) -> None:
    diagnosis(console, result.captures, result)


def _plots(result: Any) -> Mapping[str, Draw]:
    return {"candidates": lambda: candidates(result.candidates, result.error, result.ordinary)}


PRESENTATION = Presentation(
    _terminal,
    words.diagnose_headline,
    lambda result: documents.diagnosis(result.captures.name, result),
    tables.candidates,
    lambda result: diagnose_page(result.captures, result),
    _plots,
)
