"""Open capture folders in the workbench's session; optionally one round of diagnose and add.

    python benchmarks/workbench_folders.py FOLDER ... [--round] [--limit 360] [--config FILE]

A folder holds frames, or folders of frames. Prints, for each: operating points and frames shown,
the model error of the fitted Wang 2025 model, the seconds until the first frame and until the
error, and the message of what does not go. With --round: the first candidate of the diagnosis, its
confidence, the error after it is added, and the seconds of both. Exits 1 where a folder shows no
frame or a round does not end in time.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.jobs import Job
from dnanalyze.workbench.session import WorkbenchSession
from dnanalyze.workbench.source import CaptureSource

SCREEN = 192  # rows and columns of an image on the page


def folders(given: list[Path]) -> Iterator[Path]:
    """Each folder of frames: one whose children are folders without a manifest stands for them."""
    for path in given:
        inside = sorted(p for p in path.iterdir() if p.is_dir()) if path.is_dir() else []
        alone = not inside or any(p.is_file() and p.name == "manifest.csv" for p in path.iterdir())
        yield from [path] if alone else inside


def ended(job: Job | None, limit_s: float, session: WorkbenchSession) -> str:
    """Wait for a task; what went wrong, or nothing."""
    if job is not None and not job.over.wait(limit_s):
        session.cancel()
        return f"{job.task.kind} not ended after {limit_s:g} s ({job.progress})"
    return session.message


def shown(session: WorkbenchSession) -> str:
    """What the frame viewer holds: every operating point's first frame, reduced for the screen."""
    captures = session.captures
    for number in range(len(captures.settings)):
        whole = Window.whole(captures.sensor.shape)
        session.pictures.picture(View(number), whole, None, SCREEN, False)
    rows, columns = captures.sensor.shape
    return f"{len(captures.settings)} points, {captures.frame_count} frames {columns} x {rows}"


def opened(folder: Path, config: Path | None, rounds: bool, limit_s: float) -> bool:
    """Open one folder and print what it gave; whether it went."""
    begun = time.perf_counter()
    print(folder.name, end=": ", flush=True)
    try:
        session = WorkbenchSession(CaptureSource(folder, config))
    except InputError as error:
        print(f"not opened: {error}")
        return False
    try:
        print(shown(session), f"after {time.perf_counter() - begun:.1f} s", end="; ", flush=True)
        try:
            session.prepare()
        except InputError as error:
            print(f"message: {error}")
            return not rounds
        wrong = ended(session.worker.job, limit_s, session)
        error = session.present.error
        print(f"error {error:.3g} after {time.perf_counter() - begun:.1f} s", end="", flush=True)
        print(f"; message: {wrong}" if wrong else "", end="", flush=True)
        good = not rounds or diagnosed(session, limit_s)
        print()
        return good
    finally:
        session.close()


def diagnosed(session: WorkbenchSession, limit_s: float) -> bool:
    """One round of diagnose and add."""
    begun = time.perf_counter()
    if wrong := ended(session.diagnose(), limit_s, session):
        print(f"; diagnose: {wrong}", end="")
        return False
    assert session.diagnosis is not None
    took = time.perf_counter() - begun
    verdict, candidates = session.diagnosis["verdict"], session.diagnosis["candidates"]
    print(f"; diagnosis in {took:.0f} s: {verdict}", end="", flush=True)
    if not candidates:
        return True
    first, begun = candidates[0], time.perf_counter()
    print(f", {first['effect']} {100 * first['confidence']:.0f} %", end="", flush=True)
    if wrong := ended(session.add(first["effect"]), limit_s, session):
        print(f"; add: {wrong}", end="")
        return False
    took = time.perf_counter() - begun
    print(f", added in {took:.0f} s: error {session.present.error:.3g}", end="", flush=True)
    return True


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER")
    parser.add_argument("--round", action="store_true", help="diagnose and add once")
    parser.add_argument("--limit", type=float, default=360.0, help="seconds for each task")
    parser.add_argument("--config", type=Path, help="sidecar of what the files do not state")
    options = parser.parse_args()
    went = [
        opened(folder, options.config, options.round, options.limit)
        for folder in folders(options.folders)
    ]
    sys.exit(0 if all(went) else 1)


if __name__ == "__main__":
    main()
