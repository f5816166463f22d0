"""``dnanalyze check``: does the simulation meet its targets; exit 0 within, 1 outside."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dnanalyze.errors import InputError
from dnanalyze_cli.options import (
    FILES,
    EffectFiles,
    Force,
    Json,
    NoCache,
    Reading,
    Seed,
    option,
    takes,
)
from dnanalyze_cli.session import Session


@takes(Reading)
def check(
    options: Reading,
    captures: Annotated[
        str,
        typer.Argument(
            metavar="CAPTURES",
            help="The measured frames, with --model; else the simulated frames to check.",
            show_default=False,
        ),
    ],
    model: Annotated[
        Path | None,
        option(
            "--model M.yaml", "Check frames of this model, at the operating points of CAPTURES."
        ),
    ] = None,
    targets: Annotated[
        Path | None, option("--targets T.yaml", "Targets file: the limits to meet.")
    ] = None,
    init: Annotated[
        Path | None,
        option(
            "--init T.yaml",
            "Write a targets file from the measured CAPTURES, with margins that a correct "
            "simulation violates once in 1,000 runs.",
        ),
    ] = None,
    measured: Annotated[
        str | None,
        option(
            "--measured FOLDER",
            "Measured frames that targets refer to, if CAPTURES are simulated frames.",
        ),
    ] = None,
    junit: Annotated[
        Path | None, option("--junit OUT.xml", "Results as JUnit XML, for CI systems.", FILES)
    ] = None,
    markdown: Annotated[
        Path | None, option("--markdown OUT.md", "Summary for a pull request; - prints it.", FILES)
    ] = None,
    json: Json = None,
    force: Force = False,
    effects: EffectFiles = None,
    seed: Seed = None,
    no_cache: NoCache = False,
) -> int:
    """Check a simulation with targets: exit 0 within, 1 outside, 2 bad input."""
    from dnanalyze.checking.check import check as run
    from dnanalyze.checking.margins import propose
    from dnanalyze.checking.targets import dump_targets, load_targets
    from dnanalyze.loaders.writers import atomic_write
    from dnanalyze.model.channel_models import require
    from dnanalyze.report.output_files import check_kept, check_output
    from dnanalyze.report.results import checkresult as report
    from dnanalyze.report.terminal import head

    if (targets is None) == (init is None):
        raise InputError("check: give either --targets T.yaml to check, or --init T.yaml to write")
    if init is not None and (junit or markdown or json):
        raise InputError(
            "check --init: only writes the targets; leave out --junit, --markdown, --json"
        )
    if init is not None and init != Path("-"):
        check_kept(init, force, "--init")
    session = Session(
        "check",
        captures,
        json,
        output=init,
        effects=tuple(effects or ()),
        quiet=options.quiet,
        cache=not no_cache,
    )
    for path in (junit, markdown):
        if path is not None and path != Path("-"):
            check_output(path, captures)
    limits = load_targets(targets) if targets is not None else None
    own = session.model(model, seed)
    found = options.load(session)
    if own is not None:
        require(own, found.channels)
    if limits is not None and options.channel is not None:
        limits = limits.of_channel(options.channel)
    if limits is None:
        with session.progress("Simulating sensors" if own else "Measuring") as progress:
            made = propose(found, own, on_progress=progress.now)
        session.write({}, model=lambda: dump_targets(made))
        verdict, sections = report.proposed(made)
        head(session.console, found, verdict)
        session.print(sections)
        return 0
    other = None
    if measured is not None:
        from dnanalyze.loaders import load

        if own is not None:
            raise InputError(
                "check: with --model CAPTURES are the measurement; leave out --measured"
            )
        other = load(
            measured,
            config=options.config,
            tolerance_c=options.tolerance_c,
            keep_outliers=options.keep_outliers,
            mask=options.mask,
        )
    with session.progress("Checking") as progress:
        result = run(found, limits, own, measured=other, progress=progress)
    session.show(result)
    simulation = str(model) if model is not None else captures
    texts = [
        (junit, report.junit(result)),
        (markdown, report.markdown(result, str(targets), str(model) if model else None)),
    ]
    for path, text in texts:
        if path == Path("-"):
            print(text, end="")
        elif path is not None:
            atomic_write(path, text)
            session.say(f"wrote {path}")
    session.finish(result, more={"targets": targets, "model": model, "simulation": simulation})
    return 0 if result.passed else 1
