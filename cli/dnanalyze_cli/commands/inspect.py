"""``dnanalyze inspect``: what is in the folder."""

from __future__ import annotations

from dnanalyze_cli.options import ReadOptions, takes


@takes(ReadOptions)
def inspect(options: ReadOptions) -> None:
    """List what is in the folder, and what is missing for a full analysis."""
    from dnanalyze.analyzers.saturated_settings import notes, saturated_settings
    from dnanalyze.loaders import inspect as look
    from dnanalyze.report import capture_facts
    from dnanalyze.report.results import inspection as report
    from dnanalyze.report.terminal import head

    session = options.session("inspect")
    found = options.load(session)
    seen = look(found)
    seen["missing"] += notes(found, saturated_settings(found))
    head(session.console, None, capture_facts.one_line(found))
    session.print(report.sections(found, seen))
    content = report.document(options.captures, seen)
    session.write(content, lambda: report.page(found, seen), found.to_dataframe)
