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
    from dnanalyze.report.results import effects as report
    from dnanalyze.report.terminal import head

    session = Session("effects", json=json, effects=tuple(effects or ()))
    known = session.known()
    if name:
        known = {name: find(name, {**described(), **known})}
        head(session.console, None, name)
        session.print(report.effect(known[name]))
    else:
        session.print(report.catalogue(known))
    session.write(report.document(known))
