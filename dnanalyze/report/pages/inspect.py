"""The page of `inspect`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dnanalyze.report import capture
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.words import point_label, sentence


def inspect_page(captures: Any, seen: Mapping[str, Any]) -> str:
    """HTML of the page.

    Parameters
    ----------
    captures : CaptureSet
    seen : mapping
        What `dnanalyze.loaders.inspect` gave.
    """
    rows = [(point_label(p), p["frames"], p["first"]) for p in seen["operating_points"]]
    page = Page(
        "Captures",
        capture.title(captures),
        capture.one_line(captures) + ".",
        [
            Section(
                "points",
                "Operating points",
                tables=[Table(("operating point", "frames", "first file"), rows, words=3)],
            ),
            *_sources(seen),
        ],
        points=[sentence(text) for text in seen["missing"]],
        facts=capture.facts(captures) | capture.codes(seen["codes"]),
        notes=captures.notes,
    )
    return render(page)


def _sources(seen: Mapping[str, Any]) -> list[Section]:
    """Where the metadata were taken from."""
    rows = capture.sources(seen)
    table = Table(("quantity", "taken from", "for example"), rows, words=3)
    return [Section("sources", "Where the values were taken from", tables=[table])] if rows else []
