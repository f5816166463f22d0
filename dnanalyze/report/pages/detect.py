"""The page of `detect`."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.report import capture
from dnanalyze.report.figures.against_neighbours import scatter
from dnanalyze.report.figures.style import labels, layers
from dnanalyze.report.figures.suppression import suppression
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.words import is_number, number, texts

KINDS = {
    "dpc": "defect-pixel correction",
    "denoise": "spatial denoise",
    "temporal_denoise": "temporal denoise",
}


def headline(result: Any) -> str:
    """The verdict in one or two sentences."""
    said = getattr(result, "verdict", None)
    if isinstance(said, str) and " " in said:
        return said
    if not result.filtered:
        return "No sign of defect correction or denoise: these frames behave as raw ones do."
    return f"Filtered: these frames passed {KINDS.get(result.kind, result.kind)}."


def detect_page(captures: Any, result: Any, measured: Any = None) -> str:
    """HTML of the page.

    Parameters
    ----------
    captures : CaptureSet
    result : Detection
    measured : Statistics, optional
        For the figure over temperature.
    """
    flagged = [f for f in result.findings if f.flagged]
    over = [suppression(layers(measured)[0])] if measured is not None else []
    page = Page(
        "Hidden filters",
        capture.title(captures),
        headline(result),
        [
            Section("temperature", "High-frequency suppression over temperature", pictures=over),
            Section(
                "neighbours",
                "A pixel against its neighbours",
                pictures=[scatter(_frames(captures))],
            ),
            Section(
                "tests",
                "The tests",
                text=[f"{len(flagged)} of {len(result.findings)} tests are flagged, after allowing "
                      "for their number."],
                tables=[_table([f for f in result.findings if f.flagged], "Flagged", False),
                        _table([f for f in result.findings if not f.flagged], "The others", True)],
            ),
        ],
        tone="poor" if result.filtered else "good",
        points=texts(getattr(result, "evidence", None)),
        facts=capture.facts(captures),
        notes=captures.notes,
    )  # fmt: skip
    return render(page)


def _frames(captures: Any) -> list[tuple[str, np.ndarray]]:
    """The first frame of the coldest and of the warmest setting, one colour plane of it."""
    ends = list(dict.fromkeys((captures.settings[0], captures.settings[-1])))
    step = 2 if captures.sensor.cfa else 1
    return [
        (title, setting.frames[0].read()[::step, ::step])
        for title, setting in zip(labels(ends), ends, strict=True)
    ]


def _table(findings: list[Any], title: str, folded: bool) -> Table:
    rows = [
        (
            f.test,
            KINDS.get(f.kind, f.kind),
            f"{f.temperature_c:g} °C" if is_number(f.temperature_c) else "all",
            number(f.p_value, 2),
            number(f.effect_size),
        )
        for f in findings
    ]
    title = f"{title} ({len(rows)})" if rows else f"{title}: none"
    return Table(
        ("test", "points to", "at", "p", "effect"), rows, words=3, title=title, folded=folded
    )
