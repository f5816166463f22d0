"""``dnanalyze detect``: hidden DPC, denoise, temporal denoise."""

from __future__ import annotations

from dnanalyze_cli.options import ReadOptions, Scheduler, takes
from dnanalyze_cli.scheduler import executor_at


@takes(ReadOptions)
def detect(options: ReadOptions, scheduler: Scheduler = None) -> None:
    """Test whether defect correction or denoise was applied to these raw frames, and which."""
    from dnanalyze.detection.detect import detect as run

    session = options.session("detect")
    found = options.load(session)
    with executor_at(scheduler) as executor, session.progress("Reading and testing frames") as tick:
        detection = run(found, progress=tick, executor=executor)
    session.show(detection)
    session.finish(detection)
