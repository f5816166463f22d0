"""A classifier two-sample test: verdict, sections, page, document, table and figure."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from dnanalyze.classifier.result import Cell, Classification
from dnanalyze.report.documents import Document, fields_of, point
from dnanalyze.report.figures.classifier import classifier_patches
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.page import Page, Section, Table, page_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.sections.model import model_section
from dnanalyze.report.statistic_rows import POINT
from dnanalyze.report.words import point_label, varied

CELL = "view", "auc", "low", "high", "control"


def headline(result: Classification) -> str:
    """Whether a classifier distinguishes simulated from measured frames."""
    return str(result.sentence())


def sections(result: Classification) -> list[Section]:
    """What tells the frames apart, and the area at every operating point."""
    parts = varied(vars(c.point) for c in result.cells)
    rows = [
        (
            "all together" if c.point is None else point_label(c.point, parts),
            c.name,
            f"{c.auc:.2f}",
            f"{c.low:.2f} to {c.high:.2f}",
            f"{c.control:.2f}",
        )
        for c in (*result.cells, *result.together)
    ]
    columns = ("operating point", "picture", "AUC", "95 % interval", "control")
    return [
        Section(
            "classifier", "Classifier two-sample test", text=[headline(result)],
            pictures=[lambda: classifier_patches(result)], printed=False,
        ),
        Section(
            "classifier-points", "Descriptors that tell most",
            points=[words[0].upper() + words[1:] for words in result.telling],
            tables=[Table(columns, rows, words=2)],
        ),
    ]  # fmt: skip


def line(result: Classification | None) -> list[Section]:
    """Its one sentence, in the terminal below another result."""
    if result is None:
        return []
    return [Section("told", "Classifier two-sample test", text=[headline(result)], paged=False)]


def page(result: Classification) -> Page:
    """The report."""
    return page_of(
        result.captures,
        "Classifier two-sample test",
        headline(result),
        [*sections(result), model_section(result.model)],
        tone="fair" if result.reason else "poor" if result.tells else "good",
    )


def body(result: Classification) -> Document:
    """The area under the ROC curve where it tells most, and at every operating point."""
    own = fields_of(result, "auc", "low", "high", "control", "tells", "telling", "finished")
    return own | {
        "sentence": headline(result),
        "reason": result.reason or None,
        "points": [_placed(c) for c in result.cells],
        "together": [fields_of(c, *CELL) for c in result.together],
    }


def document(result: Classification) -> Document:
    """Whether a classifier can tell the simulated frames from the measured ones."""
    return made("classify", result.captures.name, **body(result), model=result.model)


def table(result: Classification) -> pd.DataFrame:
    """The area under the ROC curve by operating point and kind of picture.

    Rows without an operating point are of all operating points together.
    """
    return pd.DataFrame([_placed(c) for c in (*result.cells, *result.together)])


def _placed(cell: Cell) -> Document:
    at = dict.fromkeys(POINT) if cell.point is None else point(cell.point)
    return at | fields_of(cell, *CELL)


def plots(result: Classification) -> Mapping[str, Draw]:
    """The patches that tell most."""
    return {"patches": lambda: classifier_patches(result)}
