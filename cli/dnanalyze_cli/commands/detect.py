"""``dnanalyze detect``: hidden DPC, denoise, temporal denoise."""

from __future__ import annotations

from dnanalyze_cli.options import ReadOptions, takes


@takes(ReadOptions)
def detect(options: ReadOptions) -> None:
    """Test whether defect correction or denoise was applied to these raw frames, and which."""
    from dnanalyze.detection.detect import detect as run

    session = options.session("detect")
    found = options.load(session)
    with session.progress("Reading and testing frames") as tick:
        detection = run(found, progress=tick)
    session.show(detection)
    session.finish(detection)
