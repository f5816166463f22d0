"""``dnanalyze inspect``: what is in the folder."""

from __future__ import annotations

from dnanalyze_cli.options import Captures, Channel, Config, Csv, Json, Quiet, Report, Tolerance
from dnanalyze_cli.session import Session


def inspect(
    captures: Captures,
    json: Json = None,
    report: Report = None,
    csv: Csv = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    channel: Channel = None,
    quiet: Quiet = False,
) -> None:
    """What is in the folder, and what is missing for a full analysis."""
    from dnanalyze.analyzers.saturated_settings import notes, saturated_settings
    from dnanalyze.loaders import inspect as look
    from dnanalyze.report import documents, tables
    from dnanalyze_cli import show

    session = Session("inspect", captures, json, report, csv, quiet=quiet)
    found = session.load(config, tolerance_c, channel)
    seen = look(found)
    seen["missing"] += notes(found, saturated_settings(found))
    show.inspection(session.console, found, seen)

    def page() -> str:
        from dnanalyze.report.pages.inspect import inspect_page

        return inspect_page(found, seen)

    session.write(
        documents.inspection(captures, seen), page, lambda: tables.operating_points(found)
    )
