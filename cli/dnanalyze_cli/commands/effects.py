"""``dnanalyze effects``: the catalogue."""

from __future__ import annotations

from typing import Annotated

import typer

from dnanalyze_cli.options import EffectFiles, Json
from dnanalyze_cli.session import Session

Name = Annotated[
    str | None, typer.Argument(metavar="NAME", help="One effect in full.", show_default=False)
]


def effects(name: Name = None, json: Json = None, effects: EffectFiles = None) -> None:
    """List the effects; with NAME: physics, formula, parameters, statistics, references."""
    from dnanalyze.model.registry import described, find
    from dnanalyze.report import documents
    from dnanalyze.report.terminal.effects import catalogue, effect

    session = Session("effects", json=json, effects=tuple(effects or ()))
    known = session.known()
    if name:
        known = {name: find(name, {**described(), **known})}
        effect(session.console, known[name])
    else:
        catalogue(session.console, known)
    session.write(documents.effects(known))
