"""Long work of a session in a process of its own, which can be ended at any time."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from threading import Event, Lock, Thread, Timer
from typing import Any

from dnanalyze.workbench.source import CaptureSource
from dnanalyze.workbench.worker import Task, serve

IDLE_S = 60.0  # after a task, until its process ends: it holds the statistics in memory
YIELD_S = 10.0  # for work in the background to end, before its process is
PATIENCE_S = 0.5  # with a process that is asked to end, before it is killed


@dataclass
class Job:
    """A task under way.

    Parameters
    ----------
    task : Task
    began : float
        ``time.monotonic()`` at its start.
    progress : str
        What is being tried.
    first : str
        A first answer, before the search has confirmed it.
    background : bool
        Whether what was asked for is answered, and another task may end what is still done.
    """

    task: Task
    began: float = field(default_factory=time.monotonic)
    progress: str = "starting"
    first: str = ""
    background: bool = False
    cancelled: bool = False
    over: Event = field(default_factory=Event)

    @property
    def cancellable(self) -> bool:
        """Whether the user may end it: without the opening there is nothing to go on with."""
        return self.task.kind != "open"

    @property
    def elapsed_s(self) -> float:
        """Since its start."""
        return time.monotonic() - self.began


class Worker:
    """One worker process; it is started with the first task and keeps its statistics.

    Parameters
    ----------
    source : CaptureSource
    """

    def __init__(self, source: CaptureSource) -> None:
        self._source = source
        self._process: SpawnProcess | None = None
        self._pipe: Connection | None = None
        self._lock = Lock()
        self._rest: Timer | None = None
        self._running: Job | None = None
        self._waiting: Job | None = None  # for work in the background to end

    @property
    def job(self) -> Job | None:
        """The task asked for last, until it is over."""
        return self._waiting or self._running

    def runs(self, kind: str) -> bool:
        """Whether a task of a kind is under way, and not cancelled."""
        job = self.job
        return job is not None and job.task.kind == kind and not job.cancelled

    def start(
        self,
        task: Task,
        done: Callable[[dict[str, Any]], None],
        failed: Callable[[str], None],
        step: Callable[[dict[str, Any]], None] = lambda _: None,
    ) -> Job:
        """Begin a task; the callbacks are called from a thread of this process.

        A task that is cancelled while it waits for work in the background to end never runs.

        Raises
        ------
        RuntimeError
            A task is under way that is not in the background.
        """
        job = Job(task)
        with self._lock:
            if self._waiting is not None or (self._running and not self._running.background):
                raise RuntimeError("a task is under way")
            self._waiting = job
        self._dismiss()
        with self._lock:
            self._waiting = None
            if job.cancelled:
                job.over.set()
                return job
            self._running = job
            if self._rest is not None:
                self._rest.cancel()
            self._begin()
        assert self._pipe is not None
        pipe = self._pipe

        def listen() -> None:
            answer: tuple[str, Any] = "failed", "the worker process ended unexpectedly; try again"
            try:
                pipe.send(task)
                while True:
                    kind, content = pipe.recv()
                    if kind == "progress":
                        job.progress = content
                    elif kind == "first":
                        job.first = content
                    elif kind == "background":
                        job.progress, job.background = content, True
                    elif kind == "step":
                        if not job.cancelled:
                            step(content)
                    else:
                        answer = kind, content
                        break
            except (EOFError, OSError):
                self._end()  # so that the next task begins with a new process
            try:
                if not job.cancelled:
                    (done if answer[0] == "done" else failed)(answer[1])
            finally:  # whoever waits for the task is not kept by an error of its callbacks
                with self._lock:
                    self._running = None
                    self._rest_later()
                job.over.set()

        Thread(target=listen, daemon=True).start()
        return job

    def _rest_later(self) -> None:
        if self._rest is not None:
            self._rest.cancel()
        self._rest = Timer(IDLE_S, self.rest)
        self._rest.daemon = True
        self._rest.start()

    def _dismiss(self) -> None:
        """End work in the background; its process stays, with its statistics, if it listens."""
        with self._lock:
            job = self._running
            if job is None:
                return
            if self._pipe is not None:
                with suppress(OSError):
                    self._pipe.send(None)
        if not job.over.wait(YIELD_S):
            self._stop(job)
            job.over.wait(YIELD_S)

    def cancel(self) -> None:
        """End the task asked for last; what it has told so far stays."""
        with self._lock:
            if self._waiting is not None:
                self._waiting.cancelled = True
                return
            job = self._running
        if job is not None:
            self._stop(job)

    def _stop(self, job: Job) -> None:
        job.cancelled = True
        self._end()
        job.over.wait(PATIENCE_S)

    def rest(self) -> None:
        """End the process where no task is under way; the next task begins another."""
        with self._lock:
            if self.job is None:
                self._end()

    def close(self) -> None:
        """End the task and the process."""
        self.cancel()
        if self._rest is not None:
            self._rest.cancel()
        self._end()

    def _begin(self) -> None:
        if self._process is not None and self._process.is_alive():
            return
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=serve, args=(theirs, self._source), daemon=True)
        self._process.start()
        theirs.close()

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is None:
            return
        process.terminate()
        process.join(PATIENCE_S)
        if process.is_alive():
            process.kill()
            process.join(PATIENCE_S)
