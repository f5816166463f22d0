"""Tasks of a session: what runs, waits and is cancelled."""

from __future__ import annotations

import os
from pathlib import Path
from threading import Event, Thread

import pytest

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


@pytest.mark.skipif(not hasattr(os, "getpriority"), reason="no priorities of processes")
def test_a_task_leaves_the_processor_to_the_page(folder):
    worker = Worker(CaptureSource(folder))
    failed: list[object] = []
    worker.start(Task("detect"), lambda _: None, failed.append).over.wait(120)
    try:
        assert failed == []
        here = os.getpriority(os.PRIO_PROCESS, 0)
        assert os.getpriority(os.PRIO_PROCESS, worker._process.pid) > here
    finally:
        worker.close()
