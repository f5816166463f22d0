"""Refine and detect over the cases: a process of its own for each, one JSON line each."""

from __future__ import annotations

import json
import multiprocessing as mp
import os
import time
import traceback
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from third_party.case import Case
from third_party.folders import folder_of
from third_party.score import hidden_only


def answer(folder: Path) -> dict[str, Any]:
    """What dnanalyze says of a folder, and how long it took by the clock and in all threads."""
    from hidden_effects import outcome

    import dnanalyze

    captures = dnanalyze.load(folder)
    begun, worked = time.perf_counter(), time.process_time()
    row = outcome(dnanalyze.refine(captures))
    seconds, cpu_seconds = time.perf_counter() - begun, time.process_time() - worked
    begun = time.perf_counter()
    detection = dnanalyze.detect(dnanalyze.load(folder))
    return row | {
        "seconds": seconds,
        "cpu_seconds": cpu_seconds,
        "detected": detection.kind,
        "seconds_detect": time.perf_counter() - begun,
        "catalogue": sorted(dnanalyze.catalogue()),
    }


def described(case: Case) -> dict[str, Any]:
    """What a row tells of its case."""
    return {
        "key": case.key,
        "generator": case.generator,
        "name": case.name,
        "strength": case.strength,
        "series": case.series,
        "hides": list(case.recipe.hides),
    }


def stored(path: Path | None) -> dict[str, dict[str, Any]]:
    """Scored rows of a file by their keys; a line cut short by the end of a run is passed over."""
    rows = {}
    if path is not None and path.exists():
        for line in path.read_text("utf-8").splitlines():
            try:
                row = json.loads(line)
            except json.JSONDecodeError:
                continue
            rows[row["key"]] = hidden_only(row)
    return rows


def store(path: Path, row: dict[str, Any]) -> None:
    """Append; the line break stands first, so that a line cut short spoils no other."""
    with path.open("a", encoding="utf-8") as stream:
        stream.write("\n" + json.dumps(row, default=float))


def _child(folder: str, threads: int, pipe: Connection) -> None:
    os.environ["NUMBA_NUM_THREADS"] = str(threads)
    try:
        pipe.send(answer(Path(folder)))
    except Exception:  # a case that breaks is a result too
        pipe.send({"failed": traceback.format_exc(limit=-3)})


def run_all(
    cases: Sequence[Case], root: Path, jobs: int, limit_s: float
) -> Iterator[dict[str, Any]]:
    """Rows as they come; a case that takes longer than the limit is ended and counts as failed."""
    context, waiting, running = mp.get_context("spawn"), list(cases), {}
    threads = max(1, (os.cpu_count() or 1) // jobs)
    while waiting or running:
        while waiting and len(running) < jobs:
            case = waiting.pop(0)
            ours, theirs = context.Pipe(duplex=False)
            arguments = (str(folder_of(root, case)), threads, theirs)
            process = context.Process(target=_child, args=arguments, daemon=True)
            process.start()
            theirs.close()
            running[ours] = (case, process, time.monotonic() + limit_s)
        soonest = min(end for _, _, end in running.values())
        ready = wait(list(running), timeout=max(0.0, soonest - time.monotonic()))
        late = [p for p, (_, _, end) in running.items() if end <= time.monotonic()]
        for pipe in {*ready, *late}:
            case, process, _ = running.pop(pipe)
            row = _received(pipe) if pipe in ready else {"failed": f"over {limit_s:g} s"}
            if pipe not in ready:
                process.terminate()
            process.join()
            pipe.close()
            yield described(case) | row


def _received(pipe: Connection) -> dict[str, Any]:
    try:
        return pipe.recv()
    except EOFError:
        return {"failed": "the process died"}
