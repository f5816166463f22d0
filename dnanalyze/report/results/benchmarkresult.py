"""The outcome of a benchmark: verdict, sections, page, document, table and figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import pandas as pd

from dnanalyze.benchmarking.benchmark_value import BenchmarkValue
from dnanalyze.benchmarking.run import BenchmarkResult, RankingPlace
from dnanalyze.benchmarking.sensor_record import SensorRecord
from dnanalyze.report.documents import Document, fields_of
from dnanalyze.report.figures import benchmark as figures
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.page import Page, Section, Table
from dnanalyze.report.plain import document as made
from dnanalyze.report.plain import estimate
from dnanalyze.report.sections import benchmark as parts
from dnanalyze.report.sections.benchmark import groups, middle_of, summary
from dnanalyze.report.words import (
    celsius,
    is_number,
    listing,
    number,
    sentence,
    symbol,
    with_error,
)

SHOWN = {
    "dark_current", "temporal_noise", "dsnu", "hot_pixels", "row_noise", "read_noise",
    "activation_energy", "error_gaussian", "error_paper", "error_refined",
}  # fmt: skip
RANKING = "criterion", "title", "unit", "temperature_c"
HEADLINE = ("dark_current", "read_noise", "dsnu", "hot_pixels")


def headline(result: BenchmarkResult) -> str:
    """Who leads where, of those that are ranked, and where none does; no overall score."""
    leads: dict[str, list[str]] = {}
    alike: list[str] = []
    middle = middle_of(result)
    for ranking in summary(result):
        known = [p for p in ranking.places if p.rank is not None]
        if ranking.base not in HEADLINE or len(known) < 2:
            continue
        first = [p.sensor for p in known if p.rank == 1]
        told = "" if len(known) == len(result.sensors) else f" of the {len(known)} ranked"
        title = f"{ranking.title} ({symbol(ranking.unit)}){told}"
        if len(first) == 1:
            leads.setdefault(first[0], []).append(title)
        else:
            alike.append(title)
    at = f" at {celsius(middle)}" if is_number(middle) else ""
    if not leads:
        return f"The sensors do not differ significantly in dark current, noise or hot pixels{at}."
    parts = [f"{name} is best in {listing(titles)}" for name, titles in leads.items()]
    parts += [f"the best do not differ significantly in {listing(alike)}"] if alike else []
    return f"Of {len(result.sensors)} sensors{at}, {'; '.join(parts)}."


def sections(result: BenchmarkResult) -> list[Section]:
    """The figures at one common temperature, the effects of each, the caveats."""
    names = [s.name for s in result.sensors]
    wide = len(names) < 4  # room for names and errors
    letters = names if wide else [chr(ord("A") + i) for i in range(len(names))]
    legend = ", ".join(f"{a} {b}" for a, b in zip(letters, names, strict=True))
    shown = [r for r in summary(result) if r.base in SHOWN]
    rows = []
    for ranking in shown:
        at = f", {celsius(ranking.temperature_c)}" if ranking.temperature_c is not None else ""
        unit = f" [{symbol(ranking.unit)}]" if ranking.unit not in ("", "1") else ""
        cells = (_cell(ranking.of(name), wide) for name in names)
        rows.append((f"{ranking.title}{unit}{at}", *cells))
    known = [s for s in result.sensors if s.dn_per_e.known]
    if known:
        gains = (_cell(s.dn_per_e, wide) for s in result.sensors)
        rows.append(("conversion gain K [DN/e⁻]", *gains))
    said = [] if wide else [legend]
    notes = [
        f"K of {listing(s.name for s in known if s.dn_per_e.note == note)}: {note}"
        for note in dict.fromkeys(s.dn_per_e.note for s in known)
    ]
    notes += [
        f"{ranking.title}: {listing(alike)} are not distinguishable"
        for ranking in shown
        for alike in groups(ranking)
    ]
    notes = [sentence(note) for note in (*notes, *result.notes)]
    made_of = [
        f"{s.name}: {', '.join(e.effect for e in s.effects)} "
        f"(model error {number(s.errors.get('refined'))})"
        for s in result.sensors
        if s.effects
    ]
    return [
        Section("legend", "", text=said),
        Section("figures", "", tables=[Table(("figure", *letters), rows)]),
        Section("effects", "", text=[*made_of, *notes]),
    ]


def _cell(figure: BenchmarkValue, wide: bool) -> str:
    """With its error where there is room."""
    if not figure.known:
        return "–"
    return with_error(figure.value, figure.se) if wide else number(figure.value)


def page(result: BenchmarkResult) -> Page:
    """The report."""
    over = parts.temperatures(result)
    return Page(
        "Benchmark of sensors",
        listing(s.name for s in result.sensors),
        headline(result),
        [
            replace(over, text=(), pictures=()),
            parts.one_each(result),
            parts.rankings(result),
            parts.captures(result),
        ],
        tone="fair" if any(s.filtered for s in result.sensors) else "good",
        points=[sentence(n) for n in result.notes],
        front=[
            parts.glance(result),
            replace(over, key="curves", title="Over temperature", tables=()),
            parts.models(result),
            Section("spectra", "Spectra", pictures=[figures.spectra(result)]),
        ],
    )


def table(result: BenchmarkResult) -> pd.DataFrame:
    """One row a criterion, temperature and sensor."""
    rows = [
        fields_of(r, *RANKING)
        | {"sensor": p.sensor, **estimate(p.figure.value, p.figure.se)}
        | _place(p)
        | {"not_distinguishable_from": " ".join(p.alike)}
        for r in result.rankings
        for p in r.places
    ]
    return pd.DataFrame(rows)


def _place(place: RankingPlace) -> Document:
    """A sensor's place under a criterion."""
    return {
        "sensor": place.sensor,
        "rank": place.rank,
        "not_distinguishable_from": place.alike,
        **estimate(place.figure.value, place.figure.se),
        "note": place.figure.note,
    }


def document(result: BenchmarkResult) -> Document:
    """The JSON document."""
    folders = [s.folder for s in result.sensors]
    return made(
        "benchmark",
        ", ".join(folders),
        folders=folders,
        temperatures_c=result.temperatures,
        sensors=[_sensor(s) for s in result.sensors],
        rankings=[
            fields_of(r, *RANKING, "better") | {"places": [_place(p) for p in r.places]}
            for r in result.rankings
        ],
        notes=result.notes,
    )


def _sensor(sensor: SensorRecord) -> Document:
    return {
        **fields_of(sensor, "name", "folder"),
        "shape": sensor.sensor.shape,
        "pixel_pitch_um": sensor.sensor.pixel_pitch_um,
        "temperatures_c": sensor.temperatures,
        "dn_per_e": {
            **estimate(sensor.dn_per_e.value, sensor.dn_per_e.se),
            "note": sensor.dn_per_e.note,
        },
        **fields_of(sensor, "errors", "verdict", "notes", "filtered"),
        "effects": [
            {
                "effect": e.effect,
                "rms_dn": e.rms_dn,
                "parameters": {
                    k: {"value": v, "unit": unit} for k, (v, unit) in e.parameters.items()
                },
            }
            for e in sensor.effects
        ],
        "filter": sensor.filter_kind,
        "readings": {
            name: [vars(r) for r in readings] for name, readings in sensor.readings.items()
        },
    }


def plots(result: BenchmarkResult) -> Mapping[str, Draw]:
    """Figures over temperature, spectra, errors."""
    return {
        "temperature": lambda: figures.over_temperature(result),
        "spectra": lambda: figures.spectra(result),
        "errors": lambda: figures.errors(result),
    }
