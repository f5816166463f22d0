"""The page of `fit`."""

from __future__ import annotations

from typing import Any

from dnanalyze.report import capture
from dnanalyze.report.figures.correlations import correlations
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages.model import model_section
from dnanalyze.report.words import listing, plural, texts, with_error


def headline(result: Any) -> str:
    """What was fitted."""
    count = plural(len(result.parameters), "parameter")
    return f"Fitted {listing(result.model.names)}: {count}."


def fit_page(captures: Any, result: Any) -> str:
    """HTML of the page."""
    rows = [(p.name, with_error(p.value, p.se), p.unit) for p in result.parameters]
    names = [p.name for p in result.parameters]
    page = Page(
        "Fit",
        capture.title(captures),
        headline(result),
        [
            Section(
                "parameters",
                "Parameters",
                pictures=[correlations(names, result.correlations)],
                tables=[Table(("parameter", "value", "unit"), rows)],
            ),
            model_section(result.model),
        ],
        points=texts(result.undetermined),
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
