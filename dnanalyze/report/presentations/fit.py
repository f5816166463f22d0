"""A fit: its terminal text, document, table, page and figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from dnanalyze.report import documents, tables
from dnanalyze.report.figures.correlations import correlations
from dnanalyze.report.figures.style import Layer, layers
from dnanalyze.report.pages.fit import fit_page, headline
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.presentations.families import family_plots
from dnanalyze.report.terminal.fit import fit


def _terminal(console: Console, result: Any) -> None:
    fit(console, result.captures, result)


def simulated(result: Any) -> Sequence[Layer]:
    """The held-out data beside a simulation of the model, of a result that has both."""
    return layers(result.bench.measured[1], result.bench.statistics(result.model, errors=True)[1])


def _plots(result: Any) -> Mapping[str, Draw]:
    names = [p.name for p in result.parameters]
    return family_plots(lambda: simulated(result)) | {
        "correlations": lambda: correlations(names, result.correlations)
    }


PRESENTATION = Presentation(
    _terminal,
    headline,
    lambda result: documents.fit(result.captures.name, result, None),
    tables.parameters,
    lambda result: fit_page(result.captures, result),
    _plots,
)
