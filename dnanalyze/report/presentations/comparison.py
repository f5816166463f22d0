"""A comparison: its terminal text, document, table, page and figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from dnanalyze.report import documents, tables, words
from dnanalyze.report.figures import heatmap
from dnanalyze.report.figures.style import layers
from dnanalyze.report.pages.compare import compare_page
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.presentations.families import family_plots
from dnanalyze.report.terminal.comparison import comparison


def _terminal(console: Console, result: Any) -> None:
    comparison(console, result.captures, result)


def _plots(result: Any) -> Mapping[str, Draw]:
    own: dict[str, Draw] = {
        "families": lambda: heatmap.families(result.families, result.baselines, result.error),
        "discrepancies": lambda: heatmap.discrepancies(result.statistics),
    }
    return own | family_plots(lambda: layers(result.measured, result.simulated, result.gaussian))


PRESENTATION = Presentation(
    _terminal,
    lambda result: words.with_remarks(
        words.compare_headline(result.error, result.baselines), result
    ),
    lambda result: documents.comparison(result.captures.name, result),
    tables.comparison,
    lambda result: compare_page(result.captures, result),
    _plots,
)
