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
    scheduler: Scheduler = None,
    no_cache: NoCache = False,
    quiet: Quiet = False,
) -> None:
    """Every statistic at every operating point, with its uncertainty."""
    from dnanalyze.analyzers.analyze import analyze as run
    from dnanalyze.errors import InputError
    from dnanalyze.fitting.design import design
    from dnanalyze.fitting.predictor import bench
    from dnanalyze.report import documents, tables
    from dnanalyze_cli import show

    session = Session("analyze", captures, json, report, csv, quiet=quiet, cache=not no_cache)
    found = session.load(config, tolerance_c, channel)
    with session.progress("Analyzing") as tick:
        statistics = run(found, progress=tick, scheduler=scheduler)
        if found.source and found.source.cache:
            with suppress(InputError):  # too small to halve, which these commands will say
                bench(design(found))  # kept for compare, diagnose, refine: they read no frame again
    show.statistics(session.console, found, statistics)

    def page() -> str:
        from dnanalyze.report.pages.analyze import analyze_page

        return analyze_page(found, statistics)

    session.write(
        documents.statistics(captures, statistics), page, lambda: tables.statistics(statistics)
    )
