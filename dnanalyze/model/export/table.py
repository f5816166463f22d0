"""A model as a table of its parameters over temperature, in CSV or JSON, and back.

Each row is one parameter at one operating point. The ``law`` column holds how the parameter moves,
exactly; reading the table back takes that, so that the same model results.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.loaders.text import read_text
from dnanalyze.model.effect import Effect
from dnanalyze.model.laws import Law, TableLaw, value_at
from dnanalyze.model.noise_model import SCHEMA, NoiseModel, model_from_plain

TABLE_SCHEMA = "dnanalyze/parameters/1"
# Fmt: skip
COLUMNS = (
    "effect",
    "parameter",
    "temperature_c",
    "exposure_s",
    "gain",
    "channel",
    "value",
    "unit",
    "law",
)


def points_of(model: NoiseModel, temperatures: Sequence[float] = ()) -> list[OperatingPoint]:
    """Where to state the parameters: the points of the model's tables, else its reference.

    Parameters
    ----------
    model : NoiseModel
    temperatures : sequence of float
        C; stated at these instead, at the reference exposure and gain, for each channel.
    """
    laws = [model.pedestal, *(law for _, _, law, _ in _laws(model))]
    stated = dict.fromkeys(p for law in laws if isinstance(law, TableLaw) for p in law.points)
    named = sorted({p.channel for p in stated if p.channel is not None})
    if temperatures or not stated:
        channels: list[str | None] = [*named] or [None]
        known: list[float | None] = [*temperatures] or [model.reference.temperature_c]
        return [
            replace(model.reference_of(c), temperature_c=t, channel=c)
            for c in channels
            for t in known
        ]
    full = {_filled(p, model.reference_of(p.channel)) for p in stated}
    return sorted(full, key=OperatingPoint.sort_key)


def _filled(point: OperatingPoint, reference: OperatingPoint) -> OperatingPoint:
    """What a table's row leaves open is that of the reference."""
    given = {k: v for k, v in vars(point).items() if v is not None}
    return replace(reference, **given)


def _laws(model: NoiseModel) -> Iterator[tuple[str, str, Law, str]]:
    for effect in model.effects:
        for name, info in effect.parameters().items():
            if info.scale != "choice":
                yield effect.name, name, getattr(effect, name), info.unit


def rows(model: NoiseModel, temperatures: Sequence[float] = ()) -> list[dict[str, Any]]:
    """One row a parameter and operating point; choices (words) one row each."""
    points = points_of(model, temperatures)
    made = []
    numbers = [("", "pedestal", model.pedestal, "DN"), *_laws(model)]
    for effect, name, law, unit in numbers:
        plain = _plain(law)
        for p in points:
            row = {**vars(p), "value": value_at(law, p), "unit": unit, "law": plain}
            made.append({"effect": effect, "parameter": name, **row})
    for part in model.effects:
        if not part.parameters():
            made.append(_row(part.name, "", None))
        for name, info in part.parameters().items():
            if info.scale == "choice":
                made.append(_row(part.name, name, getattr(part, name)))
    return made


def _row(effect: str, parameter: str, choice: Any) -> dict[str, Any]:
    empty = dict.fromkeys(("temperature_c", "exposure_s", "gain", "channel", "unit"))
    plain = _plain(choice)
    return {"effect": effect, "parameter": parameter, **empty, "value": plain, "law": plain}


def _plain(law: Law) -> Any:
    return law.to_plain() if hasattr(law, "to_plain") else law


def to_json(model: NoiseModel, temperatures: Sequence[float] = ()) -> str:
    """The model and its parameters over temperature as JSON."""
    table = [{k: v for k, v in row.items() if k != "law"} for row in rows(model, temperatures)]
    content = {"schema": TABLE_SCHEMA, "model": model.to_plain(), "parameters": table}
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def to_csv(model: NoiseModel, temperatures: Sequence[float] = ()) -> str:
    """The parameters over temperature as CSV; the first rows hold what is not a parameter."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(COLUMNS)
    head = model.to_plain()
    head["order"] = model.names
    for key in ("schema", "reference", "channel_references", "seed", "order"):
        if key in head:
            writer.writerow(["", key, *[""] * 6, json.dumps(head[key])])
    for row in rows(model, temperatures):
        cells = [_cell(row[c]) for c in COLUMNS[:-1]]
        writer.writerow([*cells, json.dumps(row["law"])])
    return stream.getvalue()


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return repr(value) if isinstance(value, float) else str(value)


def read_table(path: Path, known: dict[str, type[Effect]] | None = None) -> NoiseModel:
    """The model that a table was written from, CSV or JSON by the file's ending.

    Raises
    ------
    InputError
        Not such a table; the line says what is wrong.
    """
    text = read_text(path)
    if path.suffix.lower() == ".json":
        return _from_json(text, str(path), known)
    try:
        return _from_csv(text, str(path), known)
    except csv.Error as error:
        raise InputError(f"{path}: is no CSV table: {error}") from None


def _from_json(text: str, where: str, known: dict[str, type[Effect]] | None) -> NoiseModel:
    try:
        raw = json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(f"{where}: not JSON") from None
    if not isinstance(raw, dict) or raw.get("schema") != TABLE_SCHEMA:
        raise InputError(f"{where}: not a table of parameters ({TABLE_SCHEMA})")
    return model_from_plain(raw.get("model"), where, known)


def _from_csv(text: str, where: str, known: dict[str, type[Effect]] | None) -> NoiseModel:
    reader = csv.DictReader(io.StringIO(text))
    if tuple(reader.fieldnames or ()) != COLUMNS:
        raise InputError(
            f"{where}: not a table of parameters; its columns are {', '.join(COLUMNS)}"
        )
    head: dict[str, Any] = {}
    effects: dict[str, dict[str, Any]] = {}
    try:
        for row in reader:
            law = json.loads(row["law"])
            if row["effect"]:
                own = effects.setdefault(row["effect"], {})
                if row["parameter"]:
                    own[row["parameter"]] = law
            else:
                head[row["parameter"]] = law
    except (ValueError, TypeError, RecursionError):
        raise InputError(f"{where}, line {reader.line_num}: the law is not JSON") from None
    if head.pop("schema", None) != SCHEMA or "order" not in head:
        raise InputError(f"{where}: the rows schema and order are missing; was the table cut?")
    order = head.pop("order")
    return model_from_plain(
        {**head, "effects": [{name: effects.get(name, {})} for name in order]}, where, known
    )
