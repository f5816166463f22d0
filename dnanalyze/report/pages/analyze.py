"""The page of `analyze`."""

from __future__ import annotations

from typing import Any

from dnanalyze.analyzers.estimators.arrhenius import unusual
from dnanalyze.analyzers.families.trends import law_doubts
from dnanalyze.loaders.inspection import missing
from dnanalyze.report import capture
from dnanalyze.report.figures.style import layers
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages.panels import family_panels
from dnanalyze.report.tables import laws
from dnanalyze.report.words import is_number, number, sentence, with_error


def headline(measured: Any) -> str:
    """Noise from the coldest to the warmest setting, and the law of the dark signal."""
    plane = measured.settings[0].plane
    own = [s for s in measured.settings if s.plane == plane]
    parts: list[str] = []
    for name, words in (
        ("temporal_noise", "noise between frames"),
        ("pattern_noise", "fixed pattern"),
        ("frame_noise_core", "spread over the frame"),
    ):
        values = [s.values[name].value for s in own if name in s.values]
        if values and not (name == "frame_noise_core" and parts):
            parts.append(f"{words} {_range(values)} DN")
    text = sentence("; ".join(parts)) if parts else "No noise could be measured."
    if len(laws(measured)[0]) > 1:  # several channels, each with its own
        return text
    energy = measured.trends.get("activation_energy_ev")
    step = measured.trends.get("doubling_step_c")
    if energy is not None and is_number(energy.value):
        text += f" Dark signal: activation energy {with_error(energy.value, energy.se)} eV"
        text += f", doubling every {number(step.value, 2)} °C" if step is not None else ""
        text += ", not that of a dark current." if unusual(energy.value, energy.se) else "."
    return text


def _range(values: list[float]) -> str:
    low, high = number(min(values)), number(max(values))
    return low if low == high else f"{low} to {high}"


def trend_section(measured: Any) -> Section:
    """What holds over temperature, as a table."""
    columns, found = laws(measured)
    rows = [
        (title, *(with_error(v.value, v.se) if v else "–" for v in values), unit)
        for title, values, unit in found
    ]
    table = Table(("", *columns, "unit"), rows)
    return Section("trends", "Laws over temperature", tables=[table] if rows else [])


def missing_section(measured: Any) -> Section:
    """What these frames cannot tell, with the reasons."""
    reasons = dict.fromkeys(r for s in measured.settings for r in s.missing.values())
    return Section(
        "missing", "What these frames cannot tell", points=[sentence(r) for r in reasons]
    )


def analyze_page(captures: Any, measured: Any) -> str:
    """HTML of the page."""
    page = Page(
        "Dark-frame statistics",
        capture.title(captures),
        headline(measured),
        [*family_panels(layers(measured)), trend_section(measured), missing_section(measured)],
        points=[*law_doubts(measured), *missing(captures)],
        facts=capture.facts(captures),
        notes=captures.notes,
    )
    return render(page)
