"""``dnanalyze analyze``: every statistic at every operating point."""

from __future__ import annotations

from contextlib import suppress

from dnanalyze_cli.options import NoCache, ReadOptions, Scheduler, takes


@takes(ReadOptions)
def analyze(options: ReadOptions, scheduler: Scheduler = None, no_cache: NoCache = False) -> None:
    """Measure every statistic at every operating point, with its standard error."""
    from dnanalyze.analyzers.analyze import analyze as run
    from dnanalyze.errors import InputError
    from dnanalyze.fitting.design import design
    from dnanalyze.fitting.predictor import bench
    from dnanalyze.report import documents, tables
    from dnanalyze.report.terminal.statistics import statistics as show

    session = options.session("analyze", cache=not no_cache)
    found = options.load(session)
    with session.progress("Reading frames") as tick:
        statistics = run(found, progress=tick, scheduler=scheduler)
        if found.source and found.source.cache:
            tick(0, None)
            tick.now("Storing statistics")
            with suppress(InputError):  # too small to halve, which these commands will say
                bench(design(found))  # kept for compare, diagnose, refine: they read no frame again
    show(session.console, found, statistics)

    def page() -> str:
        from dnanalyze.report.pages.analyze import analyze_page

        return analyze_page(found, statistics)

    session.write(
        documents.statistics(options.captures, statistics),
        page,
        lambda: tables.statistics(statistics),
    )
