"""``dnanalyze refine``: diagnose and add until nothing more is missing."""

from __future__ import annotations

from typing import Annotated

import typer

from dnanalyze_cli.options import (
    Captures,
    Channel,
    Config,
    Csv,
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

_STEER = "When to stop"


def refine(
    captures: Captures,
    model: Model = None,
    output: ModelOut = None,
    exclude: Annotated[
        list[str] | None,
        typer.Option(
            "--exclude",
            metavar="EFFECT",
            rich_help_panel=_STEER,
            help="Never add this one; may be given again.",
        ),
    ] = None,
    max_effects: Annotated[
        int | None,
        typer.Option(
            "--max-effects", metavar="N", min=0, rich_help_panel=_STEER, help="Add no more than N."
        ),
    ] = None,
    until_error: Annotated[
        float | None,
        typer.Option(
            "--until-error",
            metavar="E",
            min=0.0,
            rich_help_panel=_STEER,
            help="Stop once the error is E or less.",
        ),
    ] = None,
    json: Json = None,
    report: Report = None,
    csv: Csv = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    channel: Channel = None,
    effects: EffectFiles = None,
    seed: Seed = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Diagnose and add until nothing more is missing; the error at each step.

    Model, JSON and report are written at each step; an interrupted run goes on with --model.
    """
    from dnanalyze.diagnosis.refine import Refinement
    from dnanalyze.diagnosis.refine import refine as run
    from dnanalyze.model.noise_model import dump_model
    from dnanalyze.model.registry import find
    from dnanalyze.report import documents, tables, words
    from dnanalyze.report.pages.refine import refine_page
    from dnanalyze_cli import over_channels, show
    from dnanalyze_cli.going_on import command_line, kept_when_stopped

    session = Session(
        "refine",
        captures,
        json,
        report,
        csv,
        output,
        effects=tuple(effects or ()),
        quiet=quiet,
        cache=not no_cache,
    )
    known = session.known()
    for name in exclude or ():
        find(name, known)
    own = session.model(model)
    found = session.load(config, tolerance_c, channel)
    own = session.seeded(found, own, seed)
    if len(found.channels) > 1:
        from dnanalyze.diagnosis.channels import refine_channels

        over_channels.refine(
            session,
            found,
            lambda tell: refine_channels(
                found,
                own,
                exclude=tuple(exclude or ()),
                most_effects=max_effects,
                until_error=until_error,
                known=known,
                tell=tell,
            ),
        )
        return

    def keep(result: Refinement) -> None:
        so_far.append(result)
        session.keep(
            documents.refinement(captures, result, output),
            lambda: refine_page(found, result),
            lambda: tables.steps(result),
            lambda: dump_model(result.model),
        )

    def go_on() -> list[str]:
        return command_line(
            captures,
            output,
            {"--exclude": exclude, "--until-error": until_error, "--json": json, "--report": report,
             "--csv": csv, "--config": config, "--tolerance-c": tolerance_c, "--channel": channel,
             "--effects": effects},
            max_effects,
            so_far[-1] if so_far else None,
        )  # fmt: skip

    so_far: list[Refinement] = []
    with kept_when_stopped(session.files, so_far, go_on):
        with session.progress("Reading") as progress:
            held = progress.bench(found)
            result = run(
                found,
                model=own,
                held=held,
                exclude=tuple(exclude or ()),
                most_effects=max_effects,
                until_error=until_error,
                known=known,
                tell=lambda step: progress.note(
                    f"{words.number(step.error):>7}  {words.step_name(step.added, 0)}"
                ),
                trying=lambda name: progress.now(f"Trying {name}"),
                keep=keep,
            )
        with session.progress("Errors of the parameters"):
            _ = result.parameters
        show.refinement(session.console, found, result, output)

        def page() -> str:
            from dnanalyze.comparator.compare import compare

            with session.progress("Comparing"):
                comparison = compare(found, result.model, held=result.bench)
            return refine_page(found, result, comparison)

        session.write(
            documents.refinement(captures, result, output),
            page,
            lambda: tables.steps(result),
            lambda: dump_model(result.model),
        )
