"""The page of `detect`."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.report import capture
from dnanalyze.report.figures import filter_tests
from dnanalyze.report.figures.against_neighbours import scatter
from dnanalyze.report.figures.filter_tests import TITLES
from dnanalyze.report.figures.style import labels
from dnanalyze.report.figures.suppression import suppression
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.words import is_number, listing, number, percent, probability, sentence, texts

KINDS = {
    "dpc": "defect-pixel correction",
    "denoise": "spatial denoise",
    "temporal_denoise": "temporal denoise",
}
TESTS = (filter_tests.smoothing, filter_tests.corrections, filter_tests.remembering)
ESTIMATE = {
    "subkind": ("kind", ""),
    "view": ("applied to the", ""),
    "threshold_dn": ("threshold", "DN"),
    "threshold_sigma": ("threshold", "sigma"),
    "ratio": ("ratio to the neighbours' maximum", ""),
    "neighbours": ("neighbours used", ""),
    "replacement": ("replaced by", ""),
    "site_ppm": ("replaced sites", "ppm"),
    "strength": ("strength", ""),
    "from_temperature_c": ("detected from", "°C"),
}


def headline(result: Any) -> str:
    """The verdict in one or two sentences."""
    if not result.filtered and result.confidence == 0:
        return (
            "Not determined: no sign of defect-pixel correction or denoise, but these frames could "
            "show few of them."
        )
    if not result.filtered:
        return (
            "No sign of defect-pixel correction or denoise: the frames agree with unfiltered "
            "frames."
        )
    text = f"Filtered: these frames passed {KINDS.get(result.kind, result.kind)}"
    if is_number(result.confidence):
        text += f" ({percent(result.confidence)} confidence)"
    if result.also:
        text += f"; there are signs of {listing(KINDS.get(k, k) for k in result.also)} too"
    return sentence(text)


def detect_page(captures: Any, result: Any) -> str:
    """HTML of the page."""
    flagged = [f for f in result.findings if f.flagged]
    others = [f for f in result.findings if not f.flagged]
    count = f"{len(flagged)} of {len(result.findings)} tests are flagged, after Holm's correction"
    page = Page(
        "Hidden filters",
        capture.title(captures),
        headline(result),
        [
            Section(
                "ambiguous",
                "Not distinguishable from these captures",
                points=texts(result.ambiguous),
            ),
            Section(
                "tests",
                "Tests",
                text=[f"{count}."],
                pictures=[draw(result.answers) for draw in TESTS],
                tables=[t for t in (_tests(flagged, False), _tests(others, True)) if t.rows],
            ),
        ],
        tone="poor" if result.filtered else "good",
        points=texts(list(result.evidence)),
        facts=capture.facts(captures),
        front=[
            Section("estimate", "Estimated filter", tables=_estimate(result)),
            Section(
                "temperature",
                "High-frequency suppression over temperature",
                pictures=[suppression(result.series)],
                half=True,
            ),
            Section(
                "neighbours",
                "Pixels over their neighbours",
                pictures=[scatter(_frames(captures))],
                half=True,
            ),
        ],
        about=capture.about(captures),
        notes=captures.notes,
    )
    return render(page)


def _estimate(result: Any) -> list[Table]:
    """The filter's parameters, and the hot pixels that there were before it."""
    made = []
    if result.estimate is not None:
        known = [(k, v) for k, v in vars(result.estimate).items() if v is not None]
        rows = [(*ESTIMATE.get(k, (k, "")), v) for k, v in known]
        cells = [(name, number(v) if is_number(v) else str(v), unit) for name, unit, v in rows]
        made.append(Table(("property", "value", "unit"), cells, words=3))
    if result.tail:
        tail = [
            (
                f"{t.temperature_c:.4g} °C" if is_number(t.temperature_c) else "–",
                number(t.level_dn),
                number(t.ppm_seen),
                f"{number(t.ppm_lower)} to {number(t.ppm_upper)}",
            )
            for t in result.tail
        ]
        columns = ("temperature", "above [DN]", "measured [ppm]", "before correction [ppm]")
        made.append(Table(columns, tail, title="Hot pixels before correction"))
    return made


def _frames(captures: Any) -> list[tuple[str, np.ndarray]]:
    """The first frame of the coldest and of the warmest setting, one colour plane of it."""
    ends = list(dict.fromkeys((captures.settings[0], captures.settings[-1])))
    step = 2 if captures.sensor.cfa else 1
    return [
        (title, setting.frames[0].read()[::step, ::step])
        for title, setting in zip(labels(ends), ends, strict=True)
    ]


def _tests(findings: list[Any], folded: bool) -> Table:
    rows = [
        (
            TITLES.get(f.test, f.test.replace("_", " ")),
            KINDS.get(f.kind, f.kind),
            f"{f.temperature_c:.4g} °C" if is_number(f.temperature_c) else "all",
            f.view,
            probability(f.p_value),
            number(f.effect_size),
        )
        + ((f.reason,) if folded else ())
        for f in findings
    ]
    columns: tuple[str, ...] = ("test", "indicates", "temperature", "on", "p-value", "effect size")
    columns += ("not flagged because",) if folded else ()
    title = f"{'Not flagged' if folded else 'Flagged'} ({len(rows)})"
    return Table(columns, rows, words=4, title=title, folded=folded)
