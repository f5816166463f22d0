"""The page of `compare`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dnanalyze.analyzers.families.trends import law_doubts
from dnanalyze.report import capture
from dnanalyze.report.figures import heatmap
from dnanalyze.report.figures.style import layers
from dnanalyze.report.page import Page, Section, render, tone_of
from dnanalyze.report.pages.analyze import missing_section
from dnanalyze.report.pages.model import model_section
from dnanalyze.report.pages.panels import family_panels
from dnanalyze.report.words import compare_headline, number, sentence, with_remarks

CLOSE = 1.3  # error from which a model is said to fail
FIRST = 6  # failures that stand with the verdict; the rest follow


def sections(result: Any) -> list[Section]:
    """The comparison family by family, then the model: for this page and for those built on it."""
    drawn = layers(result.measured, result.simulated, result.gaussian)
    return [
        Section(
            "error",
            "Where model and sensor differ most"
            if result.error < CLOSE
            else "Where the model fails",
            points=[sentence(f) for f in result.failures[FIRST:]],
            pictures=[
                heatmap.families(result.families, result.baselines, result.error),
                heatmap.discrepancies(result.statistics),
            ],
        ),
        *family_panels(drawn, result.families, result.statistics),
        missing_section(result.measured),
        model_section(result.model),
    ]


def numbers(error: float, baselines: Mapping[str, float]) -> list[tuple[str, str]]:
    """The error beside the baselines and what a second sensor would give."""
    paper = baselines.get("paper")
    named = "error of the paper's model" if paper == error else "error of this model"
    made = [(number(error), named)]
    if paper is not None and paper != error:
        made.append((number(paper), "the paper's model"))
    if "gaussian" in baselines:
        made.append((number(baselines["gaussian"]), "a plain Gaussian"))
    return [*made, ("1", "a second sensor of the same make")]


def compare_page(captures: Any, result: Any) -> str:
    """HTML of the page."""
    baselines = result.baselines
    page = Page(
        "Model against sensor",
        capture.title(captures),
        with_remarks(compare_headline(result.error, baselines), result),
        sections(result),
        tone=tone_of(result.error),
        points=[*(sentence(f) for f in result.failures[:FIRST]), *law_doubts(result.measured)],
        figures=numbers(result.error, baselines),
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
