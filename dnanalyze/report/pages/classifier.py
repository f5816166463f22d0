"""The section of a classifier two-sample test, and its page."""

from __future__ import annotations

from typing import Any

from dnanalyze.report import capture
from dnanalyze.report.figures.classifier import classifier_patches
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages.model import model_section
from dnanalyze.report.tables import classifier_rows


def classifier_section(result: Any) -> Section:
    """The sentence, the patches that tell most, and the areas by operating point."""
    columns = ("operating point", "picture", "AUC", "95 % limits", "control")
    rows = classifier_rows(result)
    return Section(
        "classifier",
        "Classifier two-sample test",
        text=[result.sentence()],
        points=[words[0].upper() + words[1:] for words in result.telling],
        pictures=[classifier_patches(result)],
        tables=[Table(columns, rows, words=2)] if rows else [],
    )


def classifier_page(captures: Any, result: Any) -> str:
    """HTML of the page."""
    page = Page(
        "Classifier two-sample test",
        capture.title(captures),
        result.sentence(),
        [classifier_section(result), model_section(result.model)],
        tone="fair" if result.reason else "poor" if result.tells else "good",
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
