"""``dnanalyze add``: put one effect in and refit everything."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dnanalyze_cli.options import (
    Captures,
    Channel,
    Config,
    EffectFiles,
    Json,
    Model,
    ModelOut,
    NoCache,
    Quiet,
    Report,
    Seed,
    Tolerance,
)
from dnanalyze_cli.session import Session

EffectName = Annotated[
    str, typer.Argument(metavar="EFFECT", help="A name from `dnanalyze effects`.")
]


def add(
    captures: Captures,
    effect: EffectName,
    model: Model = None,
    output: ModelOut = None,
    json: Json = None,
    report: Report = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    channel: Channel = None,
    effects: EffectFiles = None,
    seed: Seed = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """The model with that effect added and everything refitted; the error before and after."""
    from dnanalyze.diagnosis.refine import add as run
    from dnanalyze.fitting.fit import fit
    from dnanalyze.model.noise_model import dump_model
    from dnanalyze.model.registry import find
    from dnanalyze.report import documents
    from dnanalyze_cli import over_channels, show

    if not Path(captures).exists() and Path(effect).exists():  # `add EFFECT CAPTURES` reads as well
        captures, effect = effect, captures
    session = Session(
        "add",
        captures,
        json,
        report,
        None,
        output,
        effects=tuple(effects or ()),
        quiet=quiet,
        cache=not no_cache,
    )
    known = session.known()
    find(effect, known)
    own = session.model(model)
    found = session.load(config, tolerance_c, channel)
    own = session.seeded(found, own, seed)
    if len(found.channels) > 1:
        from dnanalyze.diagnosis.channels import add_channels

        over_channels.refine(
            session,
            found,
            lambda tell: add_channels(found, effect, own, known=known, tell=tell),
        )
        return
    with session.progress(f"Adding {effect}") as progress:
        held = progress.bench(found)
        if own is None:
            own = fit(found, replicates=0, held=held, tell=progress.fitting(held)).model
        progress.now(f"Adding {effect}")
        result = run(found, effect, own, known=known, held=held)
    with session.progress("Errors of the parameters"):
        _ = result.parameters
    show.refinement(session.console, found, result, output, by_hand=True)

    def page() -> str:
        from dnanalyze.comparator.compare import compare
        from dnanalyze.report.pages.refine import refine_page

        with session.progress("Comparing"):
            comparison = compare(found, result.model, held=result.bench)
        return refine_page(found, result, comparison, by_hand=True)

    session.write(
        documents.addition(captures, effect, result, output),
        page,
        model=lambda: dump_model(result.model),
    )
