"""``dnanalyze describe``: what no effect of the catalogue explains."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dnanalyze.errors import InputError
from dnanalyze_cli.options import FILES, Budget, ModelOptions, ModelOut, takes


@takes(ModelOptions)
def describe(
    options: ModelOptions,
    output: ModelOut = None,
    write: Annotated[
        Path | None,
        typer.Option(
            "--write",
            metavar="OWN.py",
            rich_help_panel=FILES,
            help="Write the structure as an effect of your own, which simulates the same frames.",
        ),
    ] = None,
    force: Annotated[
        bool,
        typer.Option("--force", rich_help_panel=FILES, help="Overwrite the file of --write."),
    ] = False,
    budget: Budget = None,
) -> None:
    """Describe the residual that no effect of the catalogue explains; add it to the model."""
    from dnanalyze.description.describe import describe as run
    from dnanalyze.model.noise_model import dump_model
    from dnanalyze.report import documents, tables
    from dnanalyze.report.files import check_output
    from dnanalyze.report.pages.describe import describe_page
    from dnanalyze.report.terminal.description import description as show
    from dnanalyze.report.terminal.refinement import not_kept

    session = options.session("describe", output=output)
    session.remaining(budget)
    if write is not None:
        check_output(write, options.captures)
        if write.exists() and not force:
            raise InputError(f"--write {write}: exists; name another file, or give --force")
        if write in session.files:
            raise InputError(f"{write}: named for two outputs; give each its own file")
    found, own = options.begin(session)
    if len(found.channels) > 1:
        names = ", ".join(str(c) for c in found.channels)
        raise InputError(f"--channel: describe takes one channel; valid: {names}")
    with session.progress("Reading frames") as progress:
        held = progress.bench(found)
        result = run(
            found,
            own,
            budget=session.remaining(budget),
            known=session.known(),
            held=held,
            tell=progress.now,
        )
    show(session.console, found, result)
    if output is None and result.verdict == "described":
        not_kept(session.console)
    extra = {write: result.source()} if write is not None and result.effect is not None else {}
    session.write(
        documents.description(options.captures, result, output),
        lambda: describe_page(found, result),
        lambda: tables.description(result),
        lambda: dump_model(result.model),
        extra,
    )
