"""The model on a page: its parameters with their standard errors, and its file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from dnanalyze.diagnosis.results import Diagnosis, Refinement
from dnanalyze.fitting.fit import Fit, Parameter
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.report.page import Section, Table
from dnanalyze.report.words import (
    DIRECT,
    direct_rows,
    is_number,
    number,
    parameter_rows,
    parameter_value,
    plural,
    point_label,
    symbol,
    varied,
)

Entry = tuple[str, Any, tuple[str, str]]  # name, law, (unit, meaning)
SIDE_BY_SIDE = 6  # operating points that stand side by side


def model_section(model: NoiseModel | None, parameters: Sequence[Parameter] = ()) -> Section:
    """Every parameter with its value, unit and operating point; empty without a model.

    Parameters
    ----------
    model : NoiseModel or None
    parameters : sequence of Parameter
        With standard errors, where they were estimated.
    """
    from dnanalyze.model.noise_model import dump_model

    if model is None:
        return Section("model", "Model parameters", printed=False)
    known = {p.name: p for p in parameters}
    entries = list(_entries(model))
    fixed = [row for name, law, about in entries if (row := _fixed(name, law, about, known))]
    left = set(known) - {n for name, law, _ in entries for n in _names(name, law)}
    fixed += [(n, _value(known[n].value, n, known), symbol(known[n].unit), "", "") for n in left]
    tables = [
        *_by_point([(name, law, about) for name, law, about in entries if _table(law)], known),
        Table(("parameter", "value", "unit", "operating point", "meaning"), fixed, words=5,
              title="Parameters with one value"),
    ]  # fmt: skip
    bare = [e.name for e in model.chain if not e.parameters()]
    said = "± is the standard error." if any(is_number(p.se) for p in parameters) else ""
    more = f"Effects without parameters: {', '.join(bare)}." if bare else ""
    return Section(
        "model",
        f"Model parameters ({plural(len(model.effects), 'effect')})",
        text=[t for t in (" ".join(filter(None, (said, more))),) if t],
        tables=[t for t in tables if t.rows],
        code=dump_model(model).rstrip(),
        printed=False,
    )


def _entries(model: NoiseModel) -> Iterator[Entry]:
    """Name, law and description of every parameter."""
    yield "pedestal", model.pedestal, ("DN", "black level")
    for effect in model.chain:
        for name, about in effect.parameters().items():
            yield f"{effect.name}.{name}", getattr(effect, name), (about.unit, about.doc)


def _table(law: Any) -> bool:
    return hasattr(law, "points")


def _names(name: str, law: Any) -> list[str]:
    """As a fit names the numbers of a law."""
    if _table(law):
        return [f"{name}[{n}]" for n in range(len(law.values))]
    return [name, f"{name}.ea_ev"] if hasattr(law, "ea_ev") else [name]


def _value(value: Any, name: str, known: dict[str, Parameter]) -> str:
    found = known.get(name)
    if found is not None:
        return parameter_value(found)
    return number(value) if is_number(value) else str(value)


def _fixed(
    name: str, law: Any, about: tuple[str, str], known: dict[str, Parameter]
) -> tuple[str, ...] | None:
    """The row of a parameter that is one number, or an Arrhenius law."""
    if _table(law):
        return None
    unit, doc = about
    if not hasattr(law, "ea_ev"):
        where = "all" if is_number(law) else ""
        return name, _value(law, name, known), symbol(unit), where, doc
    energy = _value(law.ea_ev, f"{name}.ea_ev", known)
    at = f"{number(law.at_c)} °C; activation energy {energy} eV"
    return name, _value(law.value, name, known), symbol(unit), at, doc


def _by_point(entries: Sequence[Entry], known: dict[str, Parameter]) -> list[Table]:
    """Parameters with a value an operating point; side by side where they are few."""
    made: dict[tuple[Any, ...], list[tuple[str, ...]]] = {}
    for name, law, (unit, _) in entries:
        cells = [_value(v, f"{name}[{n}]", known) for n, v in enumerate(law.values)]
        made.setdefault(law.points, []).append((name, symbol(unit), *cells))
    tables = []
    for points, rows in made.items():
        heads = [point_label(p, varied(vars(q) for q in points)) for p in points]
        title = "Parameters by operating point"
        if len(points) <= SIDE_BY_SIDE:
            tables.append(Table(("parameter", "unit", *heads), rows, words=2, title=title))
            continue
        long = [
            (name, unit, head, cell)
            for name, unit, *cells in rows
            for head, cell in zip(heads, cells, strict=True)
        ]
        columns = ("parameter", "unit", "operating point", "value")
        tables.append(
            Table(columns, long, words=3, title=f"{title} ({len(long)} values)", folded=True)
        )
    return tables


def direct_section(result: Fit | Diagnosis | Refinement) -> list[Section]:
    """What the frames determine without a model, beside the model's; nothing where they do not."""
    rows = direct_rows(result)
    if not rows:
        return []
    text = "Differences within 3 standard errors or 10 % count as agreement."
    made = Table(("direct measurement", *DIRECT[1:]), rows, words=2, note=text)
    return [Section("direct", "Model and direct measurement", tables=[made])]


def parameters_section(title: str, result: Fit | Refinement) -> Section:
    """The fitted numbers in the terminal, each with its unit and its operating point."""
    rows, common = parameter_rows(result)
    told = any(at for *_, at in rows)
    columns = (title, "value", "unit", *(("at",) if told else ()))
    note = f"Operating point of the parameters: {common}." if common else ""
    table = Table(columns, [r if told else r[:-1] for r in rows], note=note, most=len(rows))
    return Section("parameters", title, tables=[table], paged=False)


def undetermined_section(result: Fit | Refinement) -> Section:
    """What the captures do not determine, in the terminal."""
    said = list(result.undetermined)
    title = "Not determined from these captures"
    return Section("undetermined", title, points=said, most=6, paged=False)
