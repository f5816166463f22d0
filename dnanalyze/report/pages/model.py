"""The model on a page: its parameters in words, and its file."""

from __future__ import annotations

from typing import Any

from dnanalyze.report.page import Section, Table
from dnanalyze.report.words import number, plural

FEW = 6  # values of a table that are written out


def model_section(model: Any) -> Section:
    """Every effect with its parameters; empty without a model."""
    from dnanalyze.model.noise_model import dump_model

    if model is None:
        return Section("model", "The model")
    rows = [("pedestal", "", law(model.pedestal), "DN", "black level")]
    for effect in model.chain:
        for place, (name, about) in enumerate(effect.parameters().items()):
            first = "" if place else effect.name
            rows.append((first, name, law(getattr(effect, name)), about.unit, about.doc))
        if not effect.parameters():
            rows.append((effect.name, "", "", "", effect.summary))
    columns = ("effect", "parameter", "value", "unit", "")
    table = Table(columns, rows, words=5, title=f"{plural(len(model.effects), 'effect')}")
    return Section("model", "The model", tables=[table], code=dump_model(model).rstrip())


def law(value: Any) -> str:
    """A parameter, whatever its law, in a few words."""
    if hasattr(value, "ea_ev"):
        return f"{number(value.value)} at {number(value.at_c)} °C, {number(value.ea_ev)} eV"
    if hasattr(value, "values"):
        if len(value.values) <= FEW:
            return ", ".join(number(v) for v in value.values)
        ends = number(min(value.values)), number(max(value.values))
        return f"{len(value.values)} values from {ends[0]} to {ends[1]}"
    return number(value, 4) if isinstance(value, (int, float)) else str(value)
