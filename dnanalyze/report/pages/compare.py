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
from dnanalyze.report.pages.classifier import classifier_section
from dnanalyze.report.pages.model import model_section
from dnanalyze.report.pages.panels import family_panels
from dnanalyze.report.words import compare_headline, number, sentence, with_remarks


def overview(result: Any) -> Section:
    """Which families and which statistics differ most."""
    return Section(
        "error",
        "Differences between sensor and model",
        pictures=[
            heatmap.families(result.families, result.baselines, result.error),
            heatmap.discrepancies(result.statistics),
        ],
    )


def families(result: Any) -> list[Section]:
    """The comparison family by family."""
    drawn = layers(result.measured, result.simulated, result.gaussian)
    return [
        *family_panels(drawn, result.families, result.statistics),
        missing_section(result.measured),
    ]


def numbers(error: float, baselines: Mapping[str, float]) -> list[tuple[str, str]]:
    """The error beside the baselines and what a second sensor would give."""
    paper = baselines.get("paper")
    named = "error of the Wang 2025 model" if paper == error else "error of this model"
    made = [(number(error), named)]
    if paper is not None and paper != error:
        made.append((number(paper), "error of the Wang 2025 model"))
    if "gaussian" in baselines:
        made.append((number(baselines["gaussian"]), "error of a Gaussian model"))
    return [*made, ("1", "a second sensor of the same design")]


def compare_page(captures: Any, result: Any, judged: Any = None) -> str:
    """HTML of the page; with a classification of the same frames, its section."""
    baselines = result.baselines
    told = [] if judged is None else [classifier_section(judged)]
    page = Page(
        "Comparison of model and sensor",
        capture.title(captures),
        with_remarks(compare_headline(result.error, baselines), result),
        [overview(result), *told, model_section(result.model), *families(result)],
        tone=tone_of(result.error),
        points=[*law_doubts(result.measured), *(sentence(f) for f in result.failures)],
        figures=numbers(result.error, baselines),
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
