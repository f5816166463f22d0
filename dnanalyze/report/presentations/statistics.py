"""Statistics: their terminal text, document, table, page and figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from dnanalyze.report import documents, tables
from dnanalyze.report.figures.dark_signal import dark_signal
from dnanalyze.report.figures.sensor_maps import sensor_maps
from dnanalyze.report.figures.style import layers
from dnanalyze.report.pages.analyze import analyze_page, headline
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.presentations.families import family_plots
from dnanalyze.report.terminal.statistics import statistics


def _terminal(console: Console, result: Any) -> None:
    statistics(console, result.captures, result)


def _plots(result: Any) -> Mapping[str, Draw]:
    own: dict[str, Draw] = {
        "sensor": lambda: sensor_maps(result),
        "dark_signal": lambda: dark_signal(result.emva),
    }
    return own | family_plots(lambda: layers(result))


PRESENTATION = Presentation(
    _terminal,
    headline,
    lambda result: documents.statistics(result.name, result, result.emva),
    tables.statistics,
    lambda result: analyze_page(result.captures, result),
    _plots,
)
