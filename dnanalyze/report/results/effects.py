"""The catalogue of effects, and one effect in full: sections and documents."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import groupby
from typing import TYPE_CHECKING

from dnanalyze.digits import number
from dnanalyze.report.documents import Document, fields_of
from dnanalyze.report.page import Section, Table
from dnanalyze.report.plain import document as made
from dnanalyze.report.words import sentence

if TYPE_CHECKING:
    from dnanalyze.model.effect import Effect, Stage


VARIES = (
    "fixed: the same in every frame; temporal: new in every frame; both: by its parameters; "
    "digital: acts on the codes.",
    "`dnanalyze effects NAME` describes one effect in full.",
)


def catalogue(known: Mapping[str, type[Effect]]) -> list[Section]:
    """All effects along the signal chain."""
    ranked = sorted(known.values(), key=lambda e: (e.stage, e.name))
    return [
        *(
            Section(
                stage.name,
                _stage(stage),
                tables=[
                    Table(
                        (_stage(stage), "", ""),
                        [(e.name, e.varies, sentence(e.summary)) for e in own],
                        words=3,
                    )
                ],
            )
            for stage, own in groupby(ranked, key=lambda e: e.stage)
        ),
        Section("varies", "", text=VARIES),
    ]


def _stage(stage: Stage) -> str:
    return str(stage.name).lower().replace("_", " ")


def effect(kind: type[Effect]) -> list[Section]:
    """One effect in full."""
    said = (
        f"{_stage(kind.stage)}, {kind.varies}",
        sentence(kind.summary),
        " ".join(kind.physics.split()),
        kind.formula,
    )
    rows = [
        (
            name,
            p.unit or "–",
            " | ".join(map(str, p.choices)) or "numbers, or none"
            if p.scale == "choice"
            else f"{number(p.lower)} to {number(p.upper)}",
            p.doc,
        )
        for name, p in kind.parameters().items()
    ]
    shows = ", ".join(kind.fingerprint)
    rivals = [f"{k}: {v.rstrip('.')}." for k, v in kind.confused_with.items()]
    return [
        *(Section("text", "", text=[text]) for text in said if text),
        Section(
            "parameters",
            "Parameters",
            tables=[Table(("parameter", "unit", "range", "meaning"), rows, words=4)],
        ),
        Section(
            "shows", "", text=[f"Statistics that respond most: {shows}"] if shows else []
        ),
        Section("rivals", "Confounded with", points=rivals),
        Section("references", "References", points=list(kind.references)),
    ]  # fmt: skip


def document(known: Mapping[str, type[Effect]]) -> Document:
    """The catalogue."""
    return made("effects", "", effects=[_effect(e) for e in known.values()])


def _effect(kind: type[Effect]) -> Document:
    """One effect of the catalogue."""
    more = "summary", "physics", "formula", "fingerprint", "confused_with", "references"
    return fields_of(kind, "name", "varies", *more) | {
        "stage": kind.stage.name.lower(),
        "parameters": {
            name: {
                "unit": p.unit,
                "lower": None if p.scale == "choice" else p.lower,
                "upper": None if p.scale == "choice" else p.upper,
                "choices": p.choices,
                "doc": p.doc,
            }
            for name, p in kind.parameters().items()
        },
    }
