"""``dnanalyze detect``: hidden DPC, denoise, temporal denoise."""

from __future__ import annotations

from dnanalyze_cli.options import ReadOptions, takes


@takes(ReadOptions)
def detect(options: ReadOptions) -> None:
    """Test whether defect correction or denoise was applied to these raw frames, and which."""
    from dnanalyze.detection.detect import detect as run
    from dnanalyze.report import documents, tables
    from dnanalyze.report.terminal.detection import detection as show

    session = options.session("detect")
    found = options.load(session)
    with session.progress("Reading and testing frames") as tick:
        detection = run(found, progress=tick)
    show(session.console, found, detection)

    def page() -> str:
        from dnanalyze.report.pages.detect import detect_page

        return detect_page(found, detection)

    session.write(
        documents.detection(options.captures, detection), page, lambda: tables.findings(detection)
    )
