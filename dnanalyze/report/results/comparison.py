"""A comparison: verdict, sections, page, document, table and figures."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from dnanalyze.analyzers.families.trends import law_doubts
from dnanalyze.classifier.result import Classification
from dnanalyze.comparator.compare import Comparison
from dnanalyze.report import words
from dnanalyze.report.documents import Document, coverage, level
from dnanalyze.report.figures import heatmap
from dnanalyze.report.figures.families import family_plots
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.figures.style import layers
from dnanalyze.report.leads import compare_lead
from dnanalyze.report.page import Page, Section, Table, page_of, tone_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.results import classification
from dnanalyze.report.results.statistics import missing_section
from dnanalyze.report.rivals import Rivals
from dnanalyze.report.sections.front import front, model_layers
from dnanalyze.report.sections.model import model_section
from dnanalyze.report.sections.panels import family_panels, largest
from dnanalyze.report.words import number, sentence


def headline(result: Comparison) -> str:
    """The model error, and what it means."""
    return words.with_remarks(words.compare_headline(result), result)


def sections(result: Comparison) -> list[Section]:
    """Where the model fails, family by family, and the largest discrepancies."""
    known = {k: v for k, v in result.families.items() if words.is_number(v)}
    top = max([*known.values(), 1.0])
    ranked = sorted(known.items(), key=lambda item: -item[1])
    errors = Table(
        ("family", "model error"),
        [(words.family_title(k), number(v)) for k, v in ranked],
        bars=[v / top for _, v in ranked],
    )
    shown = largest(result.statistics, "statistic", 8)
    return [
        Section(
            "failures", "Largest discrepancies", points=result.failures, most=6, paged=False,
            tables=[errors, *shown],
        )
    ]  # fmt: skip


def overview(result: Comparison) -> Section:
    """Which families and which statistics differ most."""
    return Section(
        "error",
        "Differences between sensor and model",
        pictures=[
            heatmap.families(result.families, result.baselines, result.error),
            heatmap.discrepancies(result.statistics),
        ],
    )


def families(result: Comparison) -> list[Section]:
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
    shown = [(number(error), named)]
    if paper is not None and paper != error:
        shown.append((number(paper), "error of the Wang 2025 model"))
    if "gaussian" in baselines:
        shown.append((number(baselines["gaussian"]), "error of a Gaussian model"))
    return [*shown, ("1", "a second sensor of the same design")]


def page(
    result: Comparison, judged: Classification | None = None, rivals: Rivals | None = None
) -> Page:
    """The report; with a classification of the same frames, its section."""
    lead = compare_lead(result)
    return page_of(
        result.captures,
        "Comparison of model and sensor",
        lead,
        [
            overview(result),
            *([] if judged is None else classification.sections(judged)),
            model_section(result.model),
            *families(result),
        ],
        tone=tone_of(result.error, result.adequate),
        points=[
            *filter(None, [words.with_remarks("", result).strip()]),  # the errors stand above
            *(s for s in map(sentence, result.failures) if s not in lead),
            *law_doubts(result.measured),
        ],
        figures=numbers(result.error, result.baselines),
        front=front(
            result, {"model": result.model}, result, rivals or Rivals(), model_layers, judged
        ),
    )


def document(result: Comparison, judged: Classification | None = None) -> Document:
    """The error, the baselines and every row behind them; the classification, if any."""
    return made(
        "compare",
        result.captures.name,
        error=result.error,
        baselines=result.baselines,
        families=result.families,
        failures=result.failures,
        unexplained=result.unexplained,
        statistics=result.statistics,
        model=result.model,
        **level(result),
        **coverage(result),
        **({} if judged is None else {"classifier": classification.body(judged)}),
    )


def table(result: Comparison) -> pd.DataFrame:
    """The rows behind the error."""
    return pd.DataFrame([dict(row) for row in result.statistics])


def plots(result: Comparison) -> Mapping[str, Draw]:
    """Errors, discrepancies, then each family of statistics."""
    own: dict[str, Draw] = {
        "families": lambda: heatmap.families(result.families, result.baselines, result.error),
        "discrepancies": lambda: heatmap.discrepancies(result.statistics),
    }
    return own | family_plots(lambda: layers(result.measured, result.simulated, result.gaussian))
