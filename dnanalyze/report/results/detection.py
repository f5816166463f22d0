"""A detection: verdict, sections, page, document, table and figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from dnanalyze.detection.results import Detection, Finding
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.report.documents import Document
from dnanalyze.report.figures import filter_tests
from dnanalyze.report.figures.filter_tests import TITLES
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.figures.pixel_and_neighbours import scatter
from dnanalyze.report.figures.style import labels
from dnanalyze.report.figures.suppression import suppression
from dnanalyze.report.page import Page, Section, Table, page_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.words import (
    FILTERS,
    celsius,
    is_number,
    listing,
    number,
    percent,
    probability,
    sentence,
    texts,
)

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


def headline(result: Detection) -> str:
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
    text = f"Filtered: these frames passed {FILTERS.get(result.kind, result.kind)}"
    if is_number(result.confidence):
        text += f" ({percent(result.confidence)} confidence)"
    if result.also:
        text += f"; there are signs of {listing(FILTERS.get(k, k) for k in result.also)} too"
    return sentence(text)


def sections(result: Detection) -> list[Section]:
    """The evidence, what is not determined, and the tests."""
    flagged = [f for f in result.findings if f.flagged]
    others = [f for f in result.findings if not f.flagged]
    count = f"{len(flagged)} of {len(result.findings)} tests are flagged, after Holm's correction"
    return [
        Section("evidence", "Evidence", points=texts(list(result.evidence)), paged=False),
        Section(
            "ambiguous",
            "Not determined from these captures",
            points=texts(list(result.ambiguous)),
        ),
        Section(
            "tests",
            "Tests",
            text=[f"{count}."],
            pictures=[draw for kind, draw in plots(result).items() if kind != "suppression"],
            tables=[_tests(flagged), _tests(others, True)],
            printed=False,
        ),
        _ranked(result),
    ]


def _tests(findings: Sequence[Finding], folded: bool = False) -> Table:
    rows = [
        (
            TITLES.get(f.test, f.test.replace("_", " ")),
            FILTERS.get(f.kind, f.kind),
            celsius(f.temperature_c) if is_number(f.temperature_c) else "all",
            f.view,
            probability(f.p_value),
            number(f.effect_size, 2),
        )
        + ((f.reason,) if folded else ())
        for f in findings
    ]
    columns: tuple[str, ...] = ("test", "indicates", "at", "on", "p-value", "effect size")
    columns += ("not flagged because",) if folded else ()
    title = f"{'Not flagged' if folded else 'Flagged'} ({len(rows)})"
    return Table(columns, rows, words=4, title=title, folded=folded)


def _ranked(result: Detection) -> Section:
    """The tests in the terminal, flagged ones first; below them why others do not count."""
    from dnanalyze.detection.verdict import NOT_SIGNIFICANT

    ranked = sorted(
        result.findings, key=lambda f: (not f.flagged, f.p_value if f.p_value is not None else 2)
    )
    shown = ranked[: max(8, min(16, sum(f.flagged for f in ranked)))]
    why = {f: "" if f.flagged or f.reason == NOT_SIGNIFICANT else f.reason for f in shown}
    reasons = list(dict.fromkeys(filter(None, why.values())))
    rows = [
        (
            f.test,
            f.view,
            celsius(f.temperature_c) if is_number(f.temperature_c) else "all",
            probability(f.p_value),
            number(f.effect_size, 2),
            "yes" if f.flagged else f"no ({reasons.index(why[f]) + 1})" if why[f] else "no",
        )
        for f in shown
    ]
    columns = ("test", "on", "at", "p-value", "effect size", "flagged")
    note = "\n".join(f"({n}) {sentence(text)}" for n, text in enumerate(reasons, 1))
    table = Table(columns, rows, words=2, note=note)
    return Section("ranked", "Tests", tables=[table], paged=False)


def page(result: Detection) -> Page:
    """The report."""
    picture = scatter(_frames(result.captures))
    return page_of(
        result.captures,
        "Hidden filters",
        headline(result),
        sections(result),
        tone="poor" if result.filtered else "good",
        points=texts(list(result.evidence)),
        front=[
            Section("estimate", "Estimated filter", tables=_estimate(result)),
            Section(
                "temperature",
                "High-frequency suppression over temperature",
                pictures=[suppression(result.series)],
                half=True,
            ),
            Section("neighbours", "Pixels over their neighbours", pictures=[picture], half=True),
        ],
    )


def _estimate(result: Detection) -> list[Table]:
    """The filter's parameters, and the hot pixels that there were before it."""
    found = {} if result.estimate is None else vars(result.estimate)
    rows = [(*ESTIMATE.get(k, (k, "")), v) for k, v in found.items() if v is not None]
    cells = [(name, number(v) if is_number(v) else str(v), unit) for name, unit, v in rows]
    tail = [
        (
            celsius(t.temperature_c) if is_number(t.temperature_c) else "–",
            number(t.level_dn),
            number(t.ppm_seen),
            f"{number(t.ppm_lower)} to {number(t.ppm_upper)}",
        )
        for t in result.tail
    ]
    columns = ("temperature", "threshold [DN]", "measured [ppm]", "before correction [ppm]")
    return [
        Table(("property", "value", "unit"), cells, words=3),
        Table(columns, tail, title="Hot pixels before correction"),
    ]


def _frames(captures: CaptureSet) -> list[tuple[str, np.ndarray]]:
    """The first frame of the coldest and of the warmest setting, one colour plane of it."""
    ends = list(dict.fromkeys((captures.settings[0], captures.settings[-1])))
    step = 2 if captures.sensor.cfa else 1
    return [
        (title, setting.frames[0].read()[::step, ::step])
        for title, setting in zip(labels(ends), ends, strict=True)
    ]


def document(result: Detection) -> Document:
    """The verdict and every test behind it."""
    return made("detect", result.captures.name, **result.to_plain())


def table(result: Detection) -> pd.DataFrame:
    """The tests."""
    keys = ("test", "kind", "temperature_c", "p_value", "effect_size", "flagged", "reason")
    return pd.DataFrame([{k: getattr(f, k) for k in keys} for f in result.findings])


def plots(result: Detection) -> Mapping[str, Draw]:
    """The figures of the tests, that of what was found first."""
    kinds: dict[str, Draw] = {
        "denoise": lambda: filter_tests.smoothing(result.findings),
        "dpc": lambda: filter_tests.corrections(result.findings),
        "temporal_denoise": lambda: filter_tests.remembering(result.findings),
        "suppression": lambda: suppression(result.series),
    }
    return {kind: kinds[kind] for kind in kinds if kind == result.kind} | kinds
