"""A learned pattern: verdict, sections, page, document, table and figure."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from dnanalyze.description.pattern import LearnedPattern
from dnanalyze.report.documents import Document, fields_of
from dnanalyze.report.figures.learned_pattern import learned_pattern
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.page import Page, Section, page_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.sections.model import model_section


def headline(result: LearnedPattern) -> str:
    """What was learned."""
    return str(result.sentence())


def sections(result: LearnedPattern) -> list[Section]:
    """What was learned, and its figure."""
    picture = [lambda: learned_pattern(result)]
    text = [headline(result)]
    return [Section("pattern", "Learned pattern", text=text, pictures=picture, printed=False)]


def page(result: LearnedPattern) -> Page:
    """The report."""
    return page_of(
        result.captures,
        "Learned pattern",
        headline(result),
        [*sections(result), model_section(result.model)],
        tone="good" if result.supported else "poor",
    )


def body(result: LearnedPattern) -> Document:
    """The learned pattern of one sensor, and what it predicts."""
    keys = "supported", "rms", "frames_share", "points_share", "error_before", "error_after"
    law = result.effect.law
    return fields_of(result, *keys) | {
        "text": headline(result),
        "law": law,
        "ea_ev": result.effect.ea_ev if law == "thermal" else None,
    }


def document(result: LearnedPattern) -> Document:
    """The pattern of one sensor, and the model with it."""
    return made("pattern", result.captures.name, **body(result), fitted=result.model.to_plain())


def table(result: LearnedPattern) -> pd.DataFrame:
    """Its size at every operating point."""
    return pd.DataFrame(
        [
            {**vars(p), "size": size, "se": se}
            for p, size, se in zip(result.points, result.sizes, result.errors, strict=True)
        ]
    )


def plots(result: LearnedPattern) -> Mapping[str, Draw]:
    """The pattern."""
    return {"pattern": lambda: learned_pattern(result)}
