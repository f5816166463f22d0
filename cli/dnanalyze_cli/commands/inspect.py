"""``dnanalyze inspect``: what is in the folder."""

from __future__ import annotations

from dnanalyze_cli.options import ReadOptions, takes


@takes(ReadOptions)
def inspect(options: ReadOptions) -> None:
    """List what is in the folder, and what is missing for a full analysis."""
    from dnanalyze.analyzers.saturated_settings import notes, saturated_settings
    from dnanalyze.loaders import inspect as look
    from dnanalyze.report import documents
    from dnanalyze.report.terminal.inspection import inspection

    session = options.session("inspect")
    found = options.load(session)
    seen = look(found)
    seen["missing"] += notes(found, saturated_settings(found))
    inspection(session.console, found, seen)

    def page() -> str:
        from dnanalyze.report.pages.inspect import inspect_page

        return inspect_page(found, seen)

    session.write(documents.inspection(options.captures, seen), page, lambda: found.to_dataframe())
