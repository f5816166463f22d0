"""A description: verdict, sections, page, document, table and figure."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from dnanalyze.description.describe import Description
from dnanalyze.description.pattern import LearnedPattern
from dnanalyze.report.documents import Document, fields_of
from dnanalyze.report.figures.description import description as picture
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.page import Page, Section, Table, page_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.plain import estimate
from dnanalyze.report.results import classification, learnedpattern
from dnanalyze.report.sections.model import model_section
from dnanalyze.report.words import (
    describe_headline,
    listing,
    number,
    sentence,
    symbol,
    with_error,
)

TONES = {"adequate": "good", "described": "good", "possible": "fair", "nothing": "poor"}
headline = describe_headline


def sections(result: Description) -> list[Section]:
    """Figure, numbers, evidence, nearest effects, further structures, recommended captures."""
    numbers = [
        (
            n.name,
            with_error(n.value, n.se),
            symbol(n.unit),
            with_error(n.in_model, n.se).split(" ±")[0],
        )
        for n in result.numbers
    ]
    near = [(n.effect, number(n.error_after), n.why) for n in result.nearest]
    rivals = ("nearest effect", "error after", "why it fails")
    gone = f"Removed from the model: {listing(result.removed)}." if result.removed else ""
    evidence = [sentence(e) for e in result.evidence]
    return [
        *classification.line(result.classification),
        Section(
            "structure",
            "Structure",
            text=[gone] if gone else [],
            pictures=[lambda: picture(result.look)],
            tables=[Table(("structure", "value", "unit", "in the model"), numbers)],
        ),
        Section("nearest", "Nearest effects", tables=[Table(rivals, near, words=3)]),
        Section("evidence", "Evidence", points=evidence, paged=False),
        Section("others", "Further structures", points=result.others),
        Section("next", "Recommended captures", points=result.next_capture),
    ]


def in_short(result: Description) -> list[Section]:
    """The sentence alone, and how to go on with it."""
    more = ["`dnanalyze describe` adds it to the model."] if result.effect is not None else []
    return [
        Section("structure", "Structure", points=[headline(result)]),
        Section("more", "", text=more),
    ]


def page(result: Description, pattern: LearnedPattern | None = None) -> Page:
    """The report, with the learned pattern, if any."""
    told = result.classification
    return page_of(
        result.captures,
        "Description",
        headline(result),
        [
            *sections(result),
            *([] if told is None else classification.sections(told)),
            *([] if pattern is None else learnedpattern.sections(pattern)),
            model_section(result.model if pattern is None else pattern.kept(result.model)),
        ],
        tone=TONES[result.verdict],
        points=[sentence(e) for e in result.evidence],
    )


def document(result: Description, pattern: LearnedPattern | None = None) -> Document:
    """Structure of the residual that no effect of the catalogue explains, in words and numbers."""
    told = result.classification
    return made(
        "describe",
        result.captures.name,
        headline=headline(result),
        description=result.text,
        **fields_of(
            result, "verdict", "error_before", "error_after", "confidence", "after", "evidence",
            "removed", "others", "next_capture", "finished",
        ),
        composite=None if result.effect is None else result.effect.to_plain(),
        numbers=[fields_of(n, "name", "value", "se", "unit", "in_model") for n in result.numbers],
        nearest=[fields_of(n, "effect", "error_after", "why") for n in result.nearest],
        effects=result.model.names,
        model=None,
        fitted=result.model.to_plain(),
        **({} if told is None else {"classifier": classification.body(told)}),
        **({} if pattern is None else {"pattern": learnedpattern.body(pattern)}),
    )  # fmt: skip


def table(result: Description) -> pd.DataFrame:
    """The numbers."""
    return pd.DataFrame(
        [
            {"name": n.name} | estimate(n.value, n.se) | {"unit": n.unit, "in_model": n.in_model}
            for n in result.numbers
        ]
    )


def plots(result: Description) -> Mapping[str, Draw]:
    """The structure."""
    return {"structure": lambda: picture(result.look)}
