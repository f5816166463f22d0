"""The page of `compare`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dnanalyze.analyzers.families.trends import law_doubts
from dnanalyze.comparator.rivals import Rivals
from dnanalyze.report import capture
from dnanalyze.report.figures import heatmap
from dnanalyze.report.figures.style import layers
from dnanalyze.report.leads import compare_lead
from dnanalyze.report.page import Page, Section, render, tone_of
from dnanalyze.report.pages.analyze import missing_section
from dnanalyze.report.pages.classifier import classifier_section
from dnanalyze.report.pages.front import (
    classifier_front,
    curves_sections,
    frames_section,
    model_layers,
    numbers_section,
    place_of,
)
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


HALF = "Measured on the held-out half of the field."


def compare_page(
    captures: Any, result: Any, judged: Any = None, rivals: Rivals | None = None
) -> str:
    """HTML of the page; with a classification of the same frames, its section."""
    baselines, rivals = result.baselines, rivals or Rivals()
    told = [] if judged is None else [classifier_section(judged)]
    place = place_of(result, rivals)
    raw = None if rivals.raw is None else rivals.raw.statistics
    lead = compare_lead(result)
    page = Page(
        "Comparison of model and sensor",
        capture.title(captures),
        lead,
        [overview(result), *told, model_section(result.model), *families(result)],
        tone=tone_of(result.error),
        points=[
            with_remarks(compare_headline(result.error, baselines), result),
            *(s for s in map(sentence, result.failures) if s not in lead),
            *law_doubts(result.measured),
        ],
        figures=numbers(result.error, baselines),
        facts=capture.facts(captures),
        notes=captures.notes,
        front=[
            frames_section(captures, place, {"model": result.model}),
            *curves_sections(model_layers(result, rivals), place, result.simulated, raw),
            *numbers_section(result.measured, HALF),
            *classifier_front(judged),
        ],
        about=capture.about(captures),
    )
    return render(page)
