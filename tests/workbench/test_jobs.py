"""Tasks of a session: what runs, waits and is cancelled."""

from __future__ import annotations

from pathlib import Path
from threading import Event, Thread

from dnanalyze.workbench.jobs import Worker
from dnanalyze.workbench.source import CaptureSource
from dnanalyze.workbench.worker import Task


def test_a_task_that_waits_for_work_in_the_background_can_be_cancelled(monkeypatch):
    worker = Worker(CaptureSource(Path("captures")))
    waits, ended = Event(), Event()
    monkeypatch.setattr(worker, "_dismiss", lambda: (waits.set(), ended.wait(30)))
    told: list[object] = []
    jobs = []
    asked = Thread(
        target=lambda: jobs.append(worker.start(Task("refine"), told.append, told.append))
    )
    asked.start()
    assert waits.wait(30)
    assert worker.job is not None
    assert worker.job.task.kind == "refine"
    worker.cancel()
    ended.set()
    asked.join(30)
    assert jobs[0].over.is_set()
    assert worker.job is None
    assert told == []
