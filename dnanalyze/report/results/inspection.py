"""What `inspect` found: sections, page and document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from dnanalyze.report import capture_facts
from dnanalyze.report.documents import Document
from dnanalyze.report.page import Page, Section, Table, page_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.words import number, point_label, sentence

if TYPE_CHECKING:
    from dnanalyze.loaders.captures import CaptureSet


MISSING = "Missing for a full analysis"


def sections(captures: CaptureSet, seen: Mapping[str, Any]) -> list[Section]:
    """Facts, operating points, sources of the metadata, and what is missing.

    Parameters
    ----------
    captures : CaptureSet
    seen : mapping
        What `dnanalyze.loaders.inspect` gave.
    """
    facts = capture_facts.facts(captures) | capture_facts.codes(seen["codes"])
    points = [
        (point_label(p), _span(p["temperature_span_c"]), p["first"], p["frames"])
        for p in seen["operating_points"]
    ]
    columns = ("operating point", "temperature range", "first file", "frames")
    said = [] if seen["missing"] else ["Nothing is missing for a full analysis."]
    return [
        Section("facts", "Captures", tables=[Table(("", ""), list(facts.items()), 2)], paged=False),
        Section("points", "Operating points", tables=[Table(columns, points, words=3)]),
        Section(
            "sources",
            "Where the values were taken from",
            tables=[
                Table(
                    ("quantity", "taken from", "for example"),
                    capture_facts.sources(seen),
                    words=3,
                    most=10,
                )
            ],
        ),
        Section("missing", MISSING, text=said, points=seen["missing"], paged=False),
    ]


def _span(span: Sequence[float] | None) -> str:
    """Width of the temperatures in one operating point."""
    return f"{number(span[1] - span[0], 2)} °C" if span and span[1] > span[0] else "–"


def page(captures: CaptureSet, seen: Mapping[str, Any]) -> Page:
    """The report."""
    return page_of(
        captures,
        "Captures",
        capture_facts.one_line(captures) + ".",
        sections(captures, seen),
        points=[sentence(text) for text in seen["missing"]],
        facts=capture_facts.codes(seen["codes"]),
    )


def document(where: str, seen: Mapping[str, Any]) -> Document:
    """The JSON document."""
    return made("inspect", where, **seen)
