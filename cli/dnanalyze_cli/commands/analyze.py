"""``dnanalyze analyze``: every statistic at every operating point."""

from __future__ import annotations

from contextlib import suppress

from dnanalyze_cli.options import (
    Captures,
    Channel,
    Config,
    Csv,
    Json,
    NoCache,
    Quiet,
    Report,
    Scheduler,
    SystemGain,
    Tolerance,
)
from dnanalyze_cli.session import Session


def analyze(
    captures: Captures,
    json: Json = None,
    report: Report = None,
    csv: Csv = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    channel: Channel = None,
    system_gain: SystemGain = None,
    scheduler: Scheduler = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """EMVA 1288 dark quantities and every statistic, with their uncertainties."""
    from dnanalyze.analyzers.analyze import analyze as run
    from dnanalyze.emva import evaluate
    from dnanalyze.errors import InputError
    from dnanalyze.fitting.design import design
    from dnanalyze.fitting.predictor import bench
    from dnanalyze.report import documents, tables
    from dnanalyze_cli import show

    if system_gain is not None and not 0 < system_gain < float("inf"):
        raise InputError(f"--system-gain {system_gain:g}: it must be above 0 DN/e-")
    session = Session("analyze", captures, json, report, csv, quiet=quiet, cache=not no_cache)
    found = session.load(config, tolerance_c, channel)
    with session.progress("Analyzing") as tick:
        statistics = run(found, progress=tick, scheduler=scheduler)
        if found.source and found.source.cache:
            with suppress(InputError):  # too small to halve, which these commands will say
                bench(design(found))  # kept for compare, diagnose, refine: they read no frame again
    quantities = evaluate(statistics, system_gain)
    show.statistics(session.console, found, statistics, quantities)

    def page() -> str:
        from dnanalyze.report.pages.analyze import analyze_page

        return analyze_page(found, statistics, quantities)

    session.write(
        documents.statistics(captures, statistics, quantities),
        page,
        lambda: tables.statistics(statistics),
    )
