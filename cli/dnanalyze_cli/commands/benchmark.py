"""``dnanalyze benchmark``: several sensors side by side."""

from __future__ import annotations

from typing import Annotated

import typer

from dnanalyze_cli.options import FolderOptions, NoCache, Scheduler, option, takes
from dnanalyze_cli.scheduler import executor_at
from dnanalyze_cli.typed_numbers import celsius


@takes(FolderOptions)
def benchmark(
    options: FolderOptions,
    folders: Annotated[
        list[str], typer.Argument(metavar="A B ...", help="Capture folders, one per sensor.")
    ],
    at: Annotated[
        str | None,
        option(
            "--at --temperatures C,C,...",
            "Temperatures, °C, to compare at; default: within the range of all sensors.",
        ),
    ] = None,
    quick: Annotated[
        bool, option("--quick", "Do not identify the effects of each sensor.")
    ] = False,
    no_cache: NoCache = False,
    scheduler: Scheduler = None,
) -> None:
    """Compare several sensors: EMVA 1288 dark quantities, tails, spectra, effects, filters."""
    from dnanalyze.benchmarking.run import benchmark as run

    temperatures = sorted(set(celsius("--at", at)))
    sessions = [options.session_on("benchmark", f, cache=not no_cache) for f in folders]
    session = sessions[0]
    found = [options.load(s) for s in sessions]
    with executor_at(scheduler) as executor, session.progress("Measuring the sensors") as progress:
        result = run(found, at=temperatures, quick=quick, progress=progress, executor=executor)
    session.show(result)
    session.finish(result, more={"captures": ", ".join(folders), "folders": folders})
