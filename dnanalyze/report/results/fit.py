"""A fit: verdict, sections, page, document, table and figures."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from dnanalyze.fitting.fit import Fit
from dnanalyze.report.documents import PARAMETER, Document, direct, fields_of
from dnanalyze.report.figures.correlations import correlations
from dnanalyze.report.figures.families import family_plots, simulated
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.page import Page, Section, page_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.plain import estimate
from dnanalyze.report.sections.model import (
    direct_section,
    model_section,
    parameters_section,
    undetermined_section,
)
from dnanalyze.report.words import listing, plural, texts


def headline(result: Fit) -> str:
    """What was fitted."""
    count = plural(len(result.parameters), "parameter")
    return f"Fitted {listing(result.model.names)}: {count}."


def sections(result: Fit) -> list[Section]:
    """Parameters with standard errors, and what the captures do not determine."""
    return [
        parameters_section("parameter", result),
        *direct_section(result),
        undetermined_section(result),
    ]


def page(result: Fit) -> Page:
    """The report."""
    names = [p.name for p in result.parameters]
    picture = correlations(names, result.correlations)
    return page_of(
        result.captures,
        "Fit",
        headline(result),
        [
            model_section(result.model, result.parameters),
            *sections(result),
            Section("correlations", "Correlation of the parameters", pictures=[picture]),
        ],
        points=texts(result.undetermined),
    )


def document(result: Fit) -> Document:
    """Parameters with their uncertainties, the pairs that the data cannot tell apart, the model."""
    return made(
        "fit",
        result.captures.name,
        parameters=[fields_of(p, *PARAMETER) for p in result.parameters],
        direct=direct(result),
        correlations=result.correlations,
        undetermined=result.undetermined,
        model=None,
        effects=result.model.names,
        fitted=result.model.to_plain(),
    )


def table(result: Fit) -> pd.DataFrame:
    """The fitted parameters."""
    return pd.DataFrame(
        [{"name": p.name} | estimate(p.value, p.se) | {"unit": p.unit} for p in result.parameters]
    )


def plots(result: Fit) -> Mapping[str, Draw]:
    """Families of statistics beside the model, and the correlations."""
    names = [p.name for p in result.parameters]
    return family_plots(lambda: simulated(result)) | {
        "correlations": lambda: correlations(names, result.correlations)
    }
