"""The page of a learned pattern, and its section on the page of `describe`."""

from __future__ import annotations

from typing import Any

from dnanalyze.report import capture
from dnanalyze.report.figures.learned_pattern import learned_pattern
from dnanalyze.report.page import Page, Section, render
from dnanalyze.report.pages.model import model_section


def pattern_section(result: Any) -> Section:
    """What was learned, and its figure."""
    picture = learned_pattern(result)
    return Section(
        "pattern", "Learned pattern", text=[result.sentence()],
        pictures=[] if picture is None else [picture],
    )  # fmt: skip


def pattern_page(captures: Any, result: Any) -> str:
    """HTML of the page."""
    page = Page(
        "Learned pattern",
        capture.title(captures),
        result.sentence(),
        [pattern_section(result), model_section(result.model)],
        tone="good" if result.supported else "poor",
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
