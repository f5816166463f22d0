"""A classifier two-sample test: its terminal text, document, table, page and figure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dnanalyze.report import documents, tables
from dnanalyze.report.figures.classifier import classifier_patches
from dnanalyze.report.pages.classifier import classifier_page
from dnanalyze.report.presentation import Draw, Presentation
from dnanalyze.report.terminal.classifier import classification


def _plots(result: Any) -> Mapping[str, Draw]:
    return {"patches": lambda: classifier_patches(result)}


PRESENTATION = Presentation(
    classification,
    lambda result: result.sentence(),
    lambda result: documents.classification(result.captures.name, result),
    tables.classifier,
    lambda result: classifier_page(result.captures, result),
    _plots,
)
