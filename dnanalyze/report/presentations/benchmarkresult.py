"""The outcome of a benchmark: its terminal text, document, table, page and figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from dnanalyze.report import benchmark
from dnanalyze.report.figures import benchmark as figures
from dnanalyze.report.pages.benchmark import benchmark_page
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.terminal.benchmark import result as shown


def _terminal(console: Console, result: Any) -> None:
    shown(console, result)


def _plots(result: Any) -> Mapping[str, Draw]:
    return {
        "temperature": lambda: figures.over_temperature(result),
        "spectra": lambda: figures.spectra(result),
        "errors": lambda: figures.errors(result),
    }


PRESENTATION = Presentation(
    _terminal,
    benchmark.headline,
    lambda result: benchmark.document([s.folder for s in result.sensors], result),
    benchmark.table,
    benchmark_page,
    _plots,
)
