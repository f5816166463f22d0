"""Statistics: verdict, sections, page, document, table and figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from dnanalyze.analyzers.families.trends import channel_trends, law_doubts
from dnanalyze.analyzers.statistics import Statistics, Value
from dnanalyze.emva import kinds
from dnanalyze.emva.quantity import Emva, Group
from dnanalyze.loaders.inspection import missing
from dnanalyze.report import emva_tables
from dnanalyze.report.documents import Document, emva_group, point
from dnanalyze.report.figures.dark_signal import dark_signal
from dnanalyze.report.figures.families import family_plots
from dnanalyze.report.figures.pictures import Draw
from dnanalyze.report.figures.sensor_maps import sensor_maps
from dnanalyze.report.figures.style import MODEL, Layer, layers
from dnanalyze.report.page import Page, Section, Table, page_of
from dnanalyze.report.plain import document as made
from dnanalyze.report.plain import estimate
from dnanalyze.report.sections.front import curves_sections, numbers_section, series_section
from dnanalyze.report.sections.panels import family_panels
from dnanalyze.report.significant_structure import (
    Structure,
    hot_share,
    plainest,
    sentence_of,
    structures,
)
from dnanalyze.report.statistic_rows import info, measured_value
from dnanalyze.report.words import number, point_label, sentence, symbol, with_error

HOT_SHARE = 1e-4  # of the pixels, from which hot pixels are named
OPEN_GROUPS = 2  # of gain, channel and colour plane, whose tables are not folded
NOTE = (
    "Symbols of EMVA 1288 Release 4.0; ± is one standard error. Dark frames only: responsivity, "
    "quantum efficiency and PRNU are not part of it."
)


def headline(measured: Statistics) -> str:
    """Temporal dark noise, DSNU, dark current and doubling interval, each with its range."""
    quantities = measured.emva
    points = emva_tables.every_point(quantities)
    parts: list[str] = []
    for kind in (kinds.NOISE, kinds.DSNU):
        values = [q.value for q in (p.quantities[kind.key] for p in points) if q.value is not None]
        if values:
            parts.append(f"{kind.name} {_range(values)} {emva_tables.unit(kind)}")
    currents = [c.quantities for g in quantities.groups for c in g.dark_currents]
    for kind in (kinds.CURRENT_E, kinds.CURRENT):
        values = [q.value for q in (c[kind.key] for c in currents) if q.value is not None]
        if values:
            parts.append(f"{kind.name} {_range(values)} {emva_tables.unit(kind)}")
            break
    found = [g.quantities[kinds.DOUBLING.key] for g in quantities.groups]
    if len(found) == 1 and found[0].determined:
        parts.append(f"doubling every {emva_tables.cell(found[0])} °C")
    if parts:
        return sentence("; ".join(parts))
    widths = [s.values["frame_noise_core"].value for s in measured.settings
              if "frame_noise_core" in s.values]  # fmt: skip
    if not widths:
        return "No noise could be measured."
    return f"Standard deviation over the pixels of one frame (central 68 %) {_range(widths)} DN."


def _range(values: list[float]) -> str:
    low, high = number(min(values)), number(max(values))
    return low if low == high else f"{low} to {high}"


def sections(measured: Statistics) -> list[Section]:
    """The EMVA 1288 quantities, the laws over temperature, what is not determined."""
    tables = list(_printed_tables(measured.emva))
    return [
        Section("quantities", "EMVA 1288 dark quantities", tables=tables, paged=False),
        trend_section(measured),
        Section("doubts", "Warnings", points=law_doubts(measured), paged=False),
        missing_section(measured, measured.emva),
    ]


def _printed_tables(quantities: Emva) -> list[Table]:
    """Tables that fit 80 columns: the sensor first, then every operating point."""
    shown = []
    groups = quantities.groups[:OPEN_GROUPS]
    for group in groups:
        where = group.label if len(quantities.groups) > 1 else ""
        points, heads = _ends(group)
        rows = emva_tables.point_rows(points, emva_tables.brief)
        shown.append(Table(("", where or "quantity", *heads), rows, words=2))
        rows = emva_tables.sensor_rows(group)
        shown.append(Table(("", "quantity", "fitted range", "value"), rows, words=3))
    points = emva_tables.every_point(quantities)
    if len(points) > 2:
        for kind, first in (
            (emva_tables.LEVELS, "operating point"),
            (emva_tables.SPLIT, "DSNU at"),
        ):
            shown.append(Table(*emva_tables.table(points, kind, first)))
    shown += [
        Table(*table) for table in map(emva_tables.current_table, groups) if len(table[1]) > 2
    ]
    return shown


def _ends(group: Group) -> tuple[Any, Sequence[str]]:
    """The operating points of lowest and highest signal, and their names."""
    points = emva_tables.ends(group)
    return points, emva_tables.labels(points) if len(points) > 1 else ["value"]


def emva_section(quantities: Emva) -> Section:
    """The quantities: of the sensor, at the ends, and folded at every operating point."""
    tables = []
    several = len(quantities.groups) > 1
    for n, group in enumerate(quantities.groups):
        points, heads = _ends(group)
        title, fold = group.label if several else "", n >= OPEN_GROUPS
        columns: emva_tables.Row = ("symbol", "quantity", "fitted range", "value")
        tables.append(
            Table(columns, emva_tables.sensor_rows(group), words=3, title=title, folded=fold)
        )
        columns = ("symbol", "quantity", *heads)
        tables.append(
            Table(columns, emva_tables.point_rows(points), words=2, title=title, folded=fold)
        )
        columns, rows = emva_tables.current_table(group)
        if len(rows) > 1:
            title = f"Dark current by temperature {title}".strip()
            tables.append(Table(columns, rows, title=title, folded=True))
    points = emva_tables.every_point(quantities)
    if len(points) > 1:
        columns, rows = emva_tables.table(points, [q.kind for q in points[0].quantities], short={})
        title = f"All quantities at {len(points)} operating points"
        tables.append(Table(columns, rows, title=title, folded=True, narrow=True))
    pictures = [dark_signal(quantities)]
    return Section("emva", "EMVA 1288 dark quantities", [NOTE], pictures=pictures, tables=tables)


def trend_section(measured: Statistics) -> Section:
    """What holds over temperature, by channel where there are several."""
    found = channel_trends(measured) or {"value": measured.trends}
    names = dict.fromkeys(n for own in found.values() for n in own if n not in emva_tables.LAWS)
    rows = [
        (
            info(name).title,
            *(_value(own.get(name)) for own in found.values()),
            symbol(info(name).unit),
        )
        for name in names
    ]
    table = Table(("over temperature", *found, "unit"), rows)
    return Section("trends", "Laws over temperature", tables=[table])


def _value(value: Value | None) -> str:
    return with_error(value.value, value.se) if value else "–"


def missing_section(measured: Statistics, quantities: Emva | None = None) -> Section:
    """What is not determined, with the reasons; EMVA 1288 quantities first where they are given."""
    first = emva_tables.undetermined(quantities) if quantities is not None else []
    return Section(
        "missing",
        "Not determined from these captures",
        points=[sentence(r) for r in (*first, *emva_tables.missing_statistics(measured))],
        most=12,
    )


def lead(measured: Statistics, found: list[Structure]) -> str:
    """What stands out of the noise, or that nothing does."""
    hot = hot_share(measured)
    if found:
        return sentence(sentence_of(found[0], measured))
    text = (
        "No structure is significant: rows, columns, neighbouring pixels and codes agree with "
        "white noise"
    )
    if hot is not None and hot[0] > HOT_SHARE:
        where = point_label(hot[1].point)
        text += f"; {number(100 * hot[0], 2)} % of the pixels are hot at {where}"
    return sentence(text)


def page(measured: Statistics, beside: Statistics | None = None) -> Page:
    """The report; with other frames of the sensor, such as processed ones, in Figures 1 and 2."""
    found, place, drawn = structures(measured), plainest(measured), layers(measured)
    captures, other = measured.captures, None
    assert captures is not None
    if beside is not None:
        names = [Path(s.name).name for s in (measured, beside)]
        drawn = (replace(drawn[0], label=names[0]),)
        other = Layer(names[1], beside, MODEL, "-", 1.2)
    return page_of(
        captures,
        "Dark-frame statistics",
        lead(measured, found),
        [
            Section("sensor", "The sensor", pictures=[sensor_maps(measured)]),
            emva_section(measured.emva),
            *family_panels(drawn),
            *sections(measured),
        ],
        tone="fair" if found else "good",
        points=[
            *(sentence(sentence_of(f, measured)) for f in found[1:]),
            headline(measured),
            *law_doubts(measured),
            *missing(captures),
        ],
        front=[
            series_section(captures, measured, place),
            *curves_sections(drawn, place, beside=other),
            *numbers_section(measured),
        ],
    )


def document(measured: Statistics) -> Document:
    """Every statistic with its standard error; the EMVA 1288 quantities under "emva"."""
    settings = [
        point(setting.point)
        | {
            "plane": setting.plane,
            "frames": setting.frames,
            "shape": setting.shape,
            "statistics": [
                {"name": name, "family": info(name).family, **_scaled(name, value)}
                for name, value in setting.values.items()
            ],
            "missing": setting.missing,
        }
        for setting in measured.settings
    ]
    channels = {name: {"trends": _values(t)} for name, t in channel_trends(measured).items()}
    return made(
        "analyze",
        measured.name,
        sensor=measured.sensor,
        settings=settings,
        trends=_values(measured.trends),
        doubts=law_doubts(measured),
        **({"channels": channels} if channels else {}),
        emva=[emva_group(g) for g in measured.emva.groups],
    )


def _values(named: Mapping[str, Value]) -> Document:
    return {k: estimate(v.value, v.se) for k, v in named.items()}


def _scaled(name: str, value: Value, repeated: bool = False) -> Document:
    """A statistic with its errors, unit and scale."""
    kind = info(name)
    about = {"unit": kind.unit, "scale": kind.scale.value}
    return measured_value(kind.scale, value, repeated) | about


def table(measured: Statistics) -> pd.DataFrame:
    """One row a statistic, operating point and colour plane; with the repeatability if known."""
    values = [v for s in measured.settings for v in s.values.values()]
    known = any(v.repeatability is not None for v in values)
    rows = [
        point(setting.point)
        | {"plane": setting.plane, "name": name, "family": info(name).family}
        | _scaled(name, value, known)
        for setting in measured.settings
        for name, value in setting.values.items()
    ]
    return pd.DataFrame(rows)


def plots(measured: Statistics) -> Mapping[str, Draw]:
    """Maps of the sensor, dark signal over exposure, then each family of statistics."""
    own: dict[str, Draw] = {
        "sensor": lambda: sensor_maps(measured),
        "dark_signal": lambda: dark_signal(measured.emva),
    }
    return own | family_plots(lambda: layers(measured))
