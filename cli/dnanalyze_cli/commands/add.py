"""``dnanalyze add``: put one effect in and refit everything."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from dnanalyze_cli.options import ModelOptions, ModelOut, takes

EffectName = Annotated[
    str, typer.Argument(metavar="EFFECT", help="A name from `dnanalyze effects`.")
]


@takes(ModelOptions)
def add(options: ModelOptions, effect: EffectName, output: ModelOut = None) -> None:
    """Add one effect to a model and refit everything; the model error before and after."""
    from dnanalyze.diagnosis.refine import add_on as run
    from dnanalyze.fitting.fit import fit_on
    from dnanalyze.model.registry import find
    from dnanalyze_cli import channel_commands

    swapped = not Path(options.captures).exists() and Path(effect).exists()
    if swapped:
        options, effect = replace(options, captures=effect), options.captures
    session = options.session("add", output=output)
    if swapped:
        print(f"note: taken as effect {effect}, captures {options.captures}", file=sys.stderr)
    known = session.known()
    find(effect, known)
    found, own = options.begin(session)
    if len(found.channels) > 1:
        from dnanalyze.channels.refinement import add_channels

        channel_commands.run_over_channels(
            session,
            found,
            lambda progress: add_channels(found, effect, own, known=known, progress=progress),
        )
        return
    with session.progress("Reading frames") as progress:
        problem = progress.fit_problem(found)
        if own is None:
            own = fit_on(
                found, replicates=0, problem=problem, on_state=progress.fitting(problem)
            ).model
        progress.now(f"Adding {effect} and refitting")
        result = run(found, effect, own, known=known, problem=problem)
        progress.now("Standard errors of the parameters")
        _ = result.parameters
    session.show(result)
    session.not_kept()
    session.finish(result)
