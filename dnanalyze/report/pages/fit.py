"""The page of `fit`."""

from __future__ import annotations

from typing import Any

from dnanalyze.report import capture
from dnanalyze.report.figures.correlations import correlations
from dnanalyze.report.page import Page, Section, render
from dnanalyze.report.pages.model import direct_section, model_section
from dnanalyze.report.words import listing, plural, texts


def headline(result: Any) -> str:
    """What was fitted."""
    count = plural(len(result.parameters), "parameter")
    return f"Fitted {listing(result.model.names)}: {count}."


def fit_page(captures: Any, result: Any) -> str:
    """HTML of the page."""
    names = [p.name for p in result.parameters]
    page = Page(
        "Fit",
        capture.title(captures),
        headline(result),
        [
            model_section(result.model, result.parameters),
            *direct_section(result),
            Section(
                "correlations",
                "Correlation of the parameters",
                pictures=[correlations(names, result.correlations)],
            ),
        ],
        points=texts(result.undetermined),
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
