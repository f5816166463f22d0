"""``dnanalyze detect``: hidden DPC, denoise, temporal denoise."""

from __future__ import annotations

from dnanalyze_cli.options import Captures, Channel, Config, Csv, Json, Quiet, Report, Tolerance
from dnanalyze_cli.session import Session


def detect(
    captures: Captures,
    json: Json = None,
    report: Report = None,
    csv: Csv = None,
    config: Config = None,
    tolerance_c: Tolerance = None,
    channel: Channel = None,
    quiet: Quiet = False,
) -> None:
    """Whether defect correction or denoise was applied to these raw frames, and which."""
    from dnanalyze.detection.detect import detect as run
    from dnanalyze.report import documents, tables
    from dnanalyze_cli import show

    session = Session("detect", captures, json, report, csv, quiet=quiet)
    found = session.load(config, tolerance_c, channel)
    with session.progress("Testing") as tick:
        detection = run(found, progress=tick)
    show.detection(session.console, found, detection)

    def page() -> str:
        from dnanalyze.report.pages.detect import detect_page

        return detect_page(found, detection)

    session.write(
        documents.detection(captures, detection), page, lambda: tables.findings(detection)
    )
