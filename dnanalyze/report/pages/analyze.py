"""The page of `analyze`."""

from __future__ import annotations

from typing import Any

from dnanalyze.analyzers.families.trends import law_doubts
from dnanalyze.emva import kinds
from dnanalyze.loaders.inspection import missing
from dnanalyze.report import capture, emva
from dnanalyze.report.figures.dark_signal import dark_signal
from dnanalyze.report.figures.sensor_maps import sensor_maps
from dnanalyze.report.figures.style import layers
from dnanalyze.report.page import Page, Section, Table, render
from dnanalyze.report.pages.front import curves_sections, numbers_section, series_section
from dnanalyze.report.pages.panels import family_panels
from dnanalyze.report.structure import Structure, hot_share, plainest, sentence_of, structures
from dnanalyze.report.tables import laws
from dnanalyze.report.words import number, point_label, sentence, with_error

HOT_SHARE = 1e-4  # of the pixels, from which hot pixels are named
OPEN_GROUPS = 2  # of gain, channel and colour plane, whose tables are not folded
NOTE = (
    "Symbols of EMVA 1288 Release 4.0; ± is one standard error. Dark frames only: responsivity, "
    "quantum efficiency and PRNU are not part of it."
)


def headline(measured: Any, quantities: Any = None) -> str:
    """Temporal dark noise, DSNU, dark current and doubling interval, each with its range."""
    quantities = measured.emva if quantities is None else quantities
    points = emva.every_point(quantities)
    parts: list[str] = []
    for kind in (kinds.NOISE, kinds.DSNU):
        values = [q.value for q in (p.quantities[kind.key] for p in points) if q.value is not None]
        if values:
            parts.append(f"{kind.name} {_range(values)} {emva.unit(kind)}")
    currents = [c.quantities for g in quantities.groups for c in g.dark_currents]
    for kind in (kinds.CURRENT_E, kinds.CURRENT):
        values = [q.value for q in (c[kind.key] for c in currents) if q.value is not None]
        if values:
            parts.append(f"{kind.name} {_range(values)} {emva.unit(kind)}")
            break
    found = [g.quantities[kinds.DOUBLING.key] for g in quantities.groups]
    if len(found) == 1 and found[0].determined:
        parts.append(f"doubling every {emva.cell(found[0])} °C")
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


def maps_section(measured: Any) -> Section:
    """The picture of the sensor."""
    return Section("sensor", "The sensor", pictures=[sensor_maps(measured)])


def emva_section(quantities: Any) -> Section:
    """The quantities: of the sensor, at the ends, and folded at every operating point."""
    tables = []
    several = len(quantities.groups) > 1
    for n, group in enumerate(quantities.groups):
        points = emva.ends(group)
        heads = emva.labels(points) if len(points) > 1 else ["value"]
        title, fold = group.label if several else "", n >= OPEN_GROUPS
        tables.append(
            Table(
                ("symbol", "quantity", "fitted range", "value"),
                emva.sensor_rows(group),
                words=3,
                title=title,
                folded=fold,
            )
        )
        rows = emva.point_rows(points)
        columns = ("symbol", "at the lowest and highest signal", *heads)
        tables.append(Table(columns, rows, words=2, title=title, folded=fold))
        columns, rows = emva.current_table(group)
        if len(rows) > 1:
            tables.append(
                Table(
                    columns, rows, title=f"Dark current by temperature {title}".strip(), folded=True
                )
            )
    points = emva.every_point(quantities)
    if len(points) > 1:
        every = [q.kind for q in points[0].quantities]
        columns, rows = emva.table(points, every, short={})
        title = f"All quantities at {len(points)} operating points"
        tables.append(Table(columns, rows, title=title, folded=True, narrow=True))
    return Section(
        "emva",
        "EMVA 1288 dark quantities",
        text=[NOTE],
        pictures=[dark_signal(quantities)],
        tables=[t for t in tables if t.rows],
    )


def trend_section(measured: Any) -> Section:
    """What holds over temperature, as a table."""
    columns, found = laws(measured, emva.LAWS)
    rows = [
        (title, *(with_error(v.value, v.se) if v else "–" for v in values), unit)
        for title, values, unit in found
    ]
    table = Table(("", *columns, "unit"), rows)
    return Section("trends", "Laws over temperature", tables=[table] if rows else [])


def missing_section(measured: Any, quantities: Any = None) -> Section:
    """What is not determined, with the reasons; EMVA 1288 quantities first where they are given."""
    first = emva.undetermined(quantities) if quantities is not None else []
    return Section(
        "missing",
        "Not determined from these captures",
        points=[sentence(r) for r in (*first, *emva.missing_statistics(measured))],
    )


def lead(measured: Any, found: list[Structure]) -> str:
    """What stands out of the noise, or that nothing does."""
    hot = hot_share(measured)
    if found:
        return sentence(sentence_of(found[0], measured))
    text = "No structure stands out: rows, columns, neighbouring pixels and codes are as by chance"
    if hot is not None and hot[0] > HOT_SHARE:
        where = point_label(hot[1].point)
        text += f"; {number(100 * hot[0], 2)} % of the pixels are hot at {where}"
    return sentence(text)


def analyze_page(captures: Any, measured: Any, quantities: Any = None) -> str:
    """HTML of the page; the EMVA 1288 quantities are worked out where they are not given."""
    quantities = quantities or measured.emva
    found, place, drawn = structures(measured), plainest(measured), layers(measured)
    page = Page(
        "Dark-frame statistics",
        capture.title(captures),
        lead(measured, found),
        [
            maps_section(measured),
            emva_section(quantities),
            *family_panels(drawn),
            trend_section(measured),
            missing_section(measured, quantities),
        ],
        tone="fair" if found else "good",
        points=[
            *(sentence(sentence_of(f, measured)) for f in found[1:]),
            headline(measured, quantities),
            *law_doubts(measured),
            *missing(captures),
        ],
        facts=capture.facts(captures),
        notes=captures.notes,
        front=[
            series_section(captures, measured, place),
            *curves_sections(drawn, place),
            *numbers_section(measured),
        ],
        about=capture.about(captures),
    )
    return render(page)
