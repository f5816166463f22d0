"""``dnanalyze analyze``: every statistic at every operating point."""

from __future__ import annotations

from contextlib import suppress
from typing import Annotated

from dnanalyze_cli.options import NoCache, ReadOptions, Scheduler, SystemGain, option, takes


@takes(ReadOptions)
def analyze(
    options: ReadOptions,
    system_gain: SystemGain = None,
    scheduler: Scheduler = None,
    no_cache: NoCache = False,
    repeatability: Annotated[
        bool,
        option(
            "--repeatability",
            "State the repeatability of each statistic (its standard deviation over captures "
            "of this sensor) in JSON and CSV. Reads the frames up to 21 times more.",
        ),
    ] = False,
    beside: Annotated[
        str | None,
        option(
            "--with CAPTURES2",
            "Other frames of the sensor, such as processed ones, drawn beside these in the "
            "report's histogram and spectra.",
        ),
    ] = None,
) -> None:
    """Measure the EMVA 1288 dark quantities and every statistic, with standard errors."""
    from dnanalyze.analyzers.analyze import analyze as run
    from dnanalyze.errors import InputError
    from dnanalyze.fitting.design import design
    from dnanalyze.fitting.problem import fit_problem
    from dnanalyze.report.results.statistics import page

    if system_gain is not None and not 0 < system_gain < float("inf"):
        raise InputError(f"--system-gain {system_gain:g}: it must be above 0 DN/e⁻")
    session = options.session("analyze", cache=not no_cache)
    if beside is not None and session.report is None:
        raise InputError("--with: it is drawn in the report; name one with --report OUT.html")
    found = options.load(session)
    with session.progress("Reading frames") as tick:
        statistics = run(found, progress=tick, scheduler=scheduler, system_gain=system_gain)
        if found.source and found.source.cache:
            tick(0, None)
            tick.now("Storing statistics")
            with suppress(InputError):  # too small to halve, which these commands will say
                fit_problem(
                    design(found)
                )  # kept for compare, diagnose, refine: they read no frame again
        if repeatability:
            from dnanalyze.analyzers.repeatability import repeatability as repeated

            tick(0, None)
            tick.now("Repeatability")
            statistics = repeated(found, statistics)
        other = None
        if beside is not None:
            tick(0, None)
            tick.now(f"Reading {beside}")
            other = run(options.load(session, beside), scheduler=scheduler)
    session.show(statistics)
    session.finish(statistics, lambda: page(statistics, other))
