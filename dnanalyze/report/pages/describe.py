"""The page of `describe`."""

from __future__ import annotations

from typing import Any

from dnanalyze.report import capture
from dnanalyze.report.figures.description import description
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages.classifier import classifier_section
from dnanalyze.report.pages.model import model_section
from dnanalyze.report.pages.pattern import pattern_section
from dnanalyze.report.terminal.description import nearest_rows, number_rows
from dnanalyze.report.words import describe_headline, listing, sentence

TONES = {"adequate": "good", "described": "good", "possible": "fair", "nothing": "poor"}


def sections(result: Any) -> list[Section]:
    """Figure, numbers, nearest effects, further structures, recommended captures."""
    numbers, near = number_rows(result), nearest_rows(result)
    columns = ("structure", "value", "unit", "in the model")
    rivals = ("nearest effect", "error after", "why it fails")
    gone = f"Removed from the model: {listing(result.removed)}." if result.removed else ""
    return [
        Section(
            "structure",
            "Structure",
            text=[gone] if gone else [],
            pictures=[description(result.look)],
            tables=[Table(columns, numbers)] if numbers else [],
        ),
        Section(
            "nearest", "Nearest effects", tables=[Table(rivals, near, words=3)] if near else []
        ),
        *([] if result.classification is None else [classifier_section(result.classification)]),
        Section("others", "Further structures", points=result.others),
        Section("next", "Recommended captures", points=result.next_capture),
    ]


def describe_page(captures: Any, result: Any, pattern: Any = None) -> str:
    """HTML of the page, with the learned pattern, if any."""
    page = Page(
        "Description",
        capture.title(captures),
        describe_headline(result),
        [
            *sections(result),
            *([] if pattern is None else [pattern_section(pattern)]),
            model_section(result.model if pattern is None else pattern.kept(result.model)),
        ],
        tone=TONES[result.verdict],
        points=[sentence(e) for e in result.evidence],
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
