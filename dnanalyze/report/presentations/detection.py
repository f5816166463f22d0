"""A detection: its terminal text, document, table, page and figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console

from dnanalyze.report import documents, tables
from dnanalyze.report.figures import filter_tests
from dnanalyze.report.figures.suppression import suppression
from dnanalyze.report.pages.detect import detect_page, headline
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.terminal.detection import detection


def _terminal(console: Console, result: Any) -> None:
    detection(console, result.captures, result)


def _plots(result: Any) -> Mapping[str, Draw]:
    kinds: dict[str, Draw] = {
        "denoise": lambda: filter_tests.smoothing(result.answers),
        "dpc": lambda: filter_tests.corrections(result.answers),
        "temporal_denoise": lambda: filter_tests.remembering(result.answers),
        "suppression": lambda: suppression(result.series),
    }
    found = {kind: kinds[kind] for kind in kinds if kind == result.kind}
    return found | kinds  # the figure of what was found first


PRESENTATION = Presentation(
    _terminal,
    headline,
    lambda result: documents.detection(result.captures.name, result),
    tables.findings,
    lambda result: detect_page(result.captures, result),
    _plots,
)
