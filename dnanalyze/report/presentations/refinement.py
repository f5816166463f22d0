"""A refinement: its terminal text, document, table, page and figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from dnanalyze.report import documents, tables, words
from dnanalyze.report.figures.waterfall import waterfall
from dnanalyze.report.pages.refine import refine_report
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.presentations.families import family_plots
from dnanalyze.report.presentations.fit import simulated
from dnanalyze.report.terminal.refinement import refinement


def _terminal(console: Console, result: Any) -> None:
    refinement(console, result.captures, result)


def _headline(result: Any) -> str:
    return words.add_headline(result) if result.by_hand else words.refine_headline(result)


def _document(result: Any) -> dict[str, Any]:
    if result.by_hand:
        return documents.addition(result.captures.name, result.steps[-1].added, result, None)
    return documents.refinement(result.captures.name, result, None)


def _plots(result: Any) -> Mapping[str, Draw]:
    own: dict[str, Draw] = {"steps": lambda: waterfall(result.steps)}
    return own | family_plots(lambda: simulated(result))


PRESENTATION = Presentation(
    _terminal,
    _headline,
    _document,
    tables.steps,
    lambda result: refine_report(result.captures, result),
    _plots,
)
