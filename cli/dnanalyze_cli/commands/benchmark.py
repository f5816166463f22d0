"""``dnanalyze benchmark``: several sensors side by side."""

from __future__ import annotations

from typing import Annotated

import typer

from dnanalyze_cli.numbers import celsius
from dnanalyze_cli.options import (
    Channel,
    Config,
    Csv,
    Json,
    KeepOutliers,
    Mask,
    NoCache,
    Quiet,
    Report,
    Tolerance,
)
from dnanalyze_cli.session import Session


def benchmark(
    folders: Annotated[
        list[str], typer.Argument(metavar="A B ...", help="Capture folders, one per sensor.")
    ],
    at: Annotated[
        str | None,
        typer.Option(
            "--at",
            "--temperatures",
            metavar="C,C,...",
            help="Temperatures, °C, to compare at; default: within the range of all sensors.",
        ),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Do not identify the effects of each sensor.")
    ] = False,
    json: Json = None,
    report: Report = None,
    csv: Csv = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    keep_outliers: KeepOutliers = False,
    mask: Mask = None,
    channel: Channel = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Compare several sensors: EMVA 1288 dark quantities, tails, spectra, effects, filters."""
    from dnanalyze.benchmarking.run import benchmark as run

    temperatures = sorted(set(celsius("--at", at)))
    sessions = [
        Session("benchmark", f, json, report, csv, quiet=quiet, cache=not no_cache) for f in folders
    ]
    session = sessions[0]
    found = [
        s.load(config, tolerance_c, channel, keep_outliers=keep_outliers, mask=mask)
        for s in sessions
    ]
    with session.progress("Measuring the sensors") as progress:
        result = run(found, at=temperatures, quick=quick, progress=progress)
    session.show(result)
    session.finish(result, more={"captures": ", ".join(folders), "folders": folders})
