"""The page of `benchmark`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dnanalyze.report.benchmark import headline
from dnanalyze.report.capture import facts
from dnanalyze.report.figures import benchmark as figures
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.words import listing, number, sentence, with_error


def benchmark_page(result: Any) -> str:
    """HTML of the page."""
    names = [s.name for s in result.sensors]
    page = Page(
        "Sensors side by side",
        listing(names),
        headline(result),
        [
            _temperatures(result),
            _one_each(result),
            _models(result),
            Section("spectra", "Spectra", pictures=[figures.spectra(result)]),
            _rankings(result),
            _captures(result),
        ],
        tone="fair" if any(s.filtered for s in result.sensors) else "good",
        points=[sentence(n) for n in result.notes],
    )
    return render(page)


def _cell(figure: Any) -> str:
    return with_error(figure.value, figure.se) if figure.known else "–"


def _temperatures(result: Any) -> Section:
    """What runs with temperature: a row a criterion and temperature, a column a sensor."""
    names = [s.name for s in result.sensors]
    cells = [
        (r.title, r.unit, f"{r.temperature_c:g}", *(_cell(r.of(n)) for n in names))
        for r in result.rankings
        if r.temperature_c is not None
    ]
    return Section(
        "temperatures",
        "At common temperatures",
        text=[
            "Each figure is read off the sensor's own law over temperature. Its error holds what "
            "that costs: sampling, misfit, the choice of the law, and the distance to what was "
            "measured."
        ],
        pictures=[figures.over_temperature(result)],
        tables=[Table(("figure", "unit", "°C", *names), cells, words=2, sortable=True)],
    )


def _one_each(result: Any) -> Section:
    names = [s.name for s in result.sensors]
    cells = [
        (r.title, r.unit, *(_cell(r.of(n)) for n in names))
        for r in result.rankings
        if r.temperature_c is None and not r.criterion.startswith("error_")
    ]
    gains = ("conversion gain", "DN/e-", *(_cell(s.dn_per_e) for s in result.sensors))
    return Section(
        "figures",
        "One figure each",
        tables=[Table(("figure", "unit", *names), [*cells, gains], words=2, sortable=True)],
    )


def _models(result: Any) -> Section:
    """How well each is described, and by which effects."""
    rows = []
    for s in result.sensors:
        kind = "not tested" if s.filtered is None else "no"
        if s.filtered:
            kind = f"yes: {s.filter_kind.replace('_', ' ')}"
        rows.append(
            (s.name, kind, *(number(s.errors.get(k)) for k in ("gaussian", "paper", "refined")))
        )
    columns = ("sensor", "filtered", "Gaussian", "paper's model", "refined")
    tables = [Table(columns, rows, words=2, sortable=True)]
    strengths = [
        (e.effect, s.name, number(e.rms_dn), _numbers(e.parameters))
        for s in result.sensors
        for e in s.effects
    ]
    if strengths:
        names = [s.name for s in result.sensors]
        head, title = ("effect", "sensor", "rms [DN]", "parameters"), "Parameters of every effect"
        tables.append(Table(("rms of the effect [DN]", *names), _strengths(result), sortable=True))
        tables.append(Table(head, sorted(strengths), words=4, title=title, folded=True))
    return Section(
        "models",
        "What each sensor is made of",
        text=[
            "A filtered output flatters noise, hot pixels and spectra: such figures are not "
            "the sensor's."
        ],
        pictures=[figures.errors(result)],
        tables=tables,
    )


def _strengths(result: Any) -> list[tuple[str, ...]]:
    """A row an effect, a column a sensor: its rms, "yes" where no closed form tells it."""
    effects = dict.fromkeys(e.effect for s in result.sensors for e in s.effects)
    found = [{e.effect: e for e in s.effects} for s in result.sensors]

    def cell(effect: Any) -> str:
        if effect is None:
            return "–"
        return "yes" if effect.rms_dn is None else number(effect.rms_dn)

    return [(name, *(cell(own.get(name)) for own in found)) for name in effects]


def _numbers(parameters: Mapping[str, tuple[float, str]]) -> str:
    """``sigma 2.1 DN, tau 3``."""
    return ", ".join(
        f"{key} {number(value)}{f' {unit}' if unit not in ('', '1') else ''}"
        for key, (value, unit) in parameters.items()
    )


def _rankings(result: Any) -> Section:
    """Per criterion, best first."""
    rows = []
    for r in result.rankings:
        ranked = [p for p in r.places if p.rank is not None]
        if len(ranked) < 2:
            continue
        at = f"{r.temperature_c:g}\N{NO-BREAK SPACE}°C" if r.temperature_c is not None else ""
        order = "   ".join(f"{p.rank}. {p.sensor} ({_cell(p.figure)})" for p in ranked)
        rows.append((r.title, r.unit, at, order))
    return Section(
        "rankings",
        "Ranking per criterion",
        text=["Sensors whose figures differ by less than two standard errors share a rank."],
        tables=[Table(("criterion", "unit", "at", "best first"), rows, words=4)] if rows else [],
    )


def _captures(result: Any) -> Section:
    keys = ("frames", "temperature", "exposure", "gain")
    rows = [(s.name, *(facts(s.captures).get(k, "–") for k in keys)) for s in result.sensors]
    notes = [f"{s.name}: {sentence(n)}" for s in result.sensors for n in s.notes]
    columns = ("sensor", *keys)
    return Section("captures", "The captures", points=notes, tables=[Table(columns, rows, words=5)])
