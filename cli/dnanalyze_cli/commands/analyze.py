"""``dnanalyze analyze``: every statistic at every operating point."""

from __future__ import annotations

from dnanalyze_cli.options import Captures, Config, Csv, Json, Quiet, Report, Tolerance
from dnanalyze_cli.session import Session


def analyze(
    captures: Captures,
    json: Json = None,
    report: Report = None,
    csv: Csv = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    quiet: Quiet = False,
) -> None:
    """Every statistic at every operating point, with its uncertainty."""
    from dnanalyze.analyzers.analyze import analyze as run
    from dnanalyze.report import documents, tables
    from dnanalyze_cli import show

    session = Session("analyze", captures, json, report, csv, quiet=quiet)
    found = session.load(config, tolerance_c)
    with session.progress("Analyzing") as tick:
        statistics = run(found, progress=tick)
    show.statistics(session.console, found, statistics)

    def page() -> str:
        from dnanalyze.report.pages.analyze import analyze_page

        return analyze_page(found, statistics)

    session.write(
        documents.statistics(captures, statistics), page, lambda: tables.statistics(statistics)
    )
