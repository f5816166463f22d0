"""Begun and cancelled tasks and a killed worker, on the workbench's page.

    python benchmarks/workbench_mishaps.py [FOLDER] [--cancels 10]

Without a folder a virtual sensor of 5 temperatures x 8 frames x 512 x 512 is made. Prints the time
from the click on Cancel until the page says that the task is over, at moments spread over the first
seconds of a refinement; the time from the click on Add until its bar and Cancel show; and the time
from the worker's death to the message, with the error before and after a fit in a new worker. Needs
the extra `workbench`, Playwright and Debian's chromium.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from workbench import FLAGS, served, settled, virtual_sensor


def workers(server: int) -> list[int]:
    """Worker processes of a server."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
            words = (path.parent / "cmdline").read_text()
        except OSError:
            continue
        if int(fields[1]) == server and "spawn_main" in words:
            found.append(int(path.parent.name))
    return found


def under_way(page: Any) -> None:
    """Wait until a task runs."""
    page.locator("button:enabled", has_text="Cancel").wait_for()


def cancelled(page: Any, after_s: float) -> float:
    """Seconds from the click on Cancel to the page at rest, so long after a refinement began."""
    page.get_by_role("button", name="Refine").click()
    under_way(page)
    page.wait_for_timeout(1000 * after_s)
    begun = time.perf_counter()
    page.get_by_role("button", name="Cancel").click()
    page.locator("button:disabled", has_text="Cancel").wait_for()
    return time.perf_counter() - begun


def added(page: Any) -> float:
    """Seconds from the click on the first candidate's Add until the task shows."""
    page.get_by_role("button", name="Diagnose").click()
    under_way(page)
    page.locator(".row").first.wait_for()
    page.locator("button:enabled", has_text="Diagnose").wait_for()
    begun = time.perf_counter()
    page.locator(".row").first.get_by_role("button", name="Add").click()
    page.get_by_text("Adding:").wait_for()
    under_way(page)
    return time.perf_counter() - begun


def killed(page: Any, server: int) -> float:
    """Seconds from the death of the worker to the message."""
    page.get_by_role("button", name="Refine").click()
    under_way(page)
    page.wait_for_timeout(1500)
    begun = time.perf_counter()
    for worker in workers(server):
        os.kill(worker, signal.SIGKILL)
    page.get_by_text("ended unexpectedly").wait_for()
    return time.perf_counter() - begun


def measured(folder: Path, cancels: int) -> None:
    """Print every figure."""
    from playwright.sync_api import sync_playwright

    with served(folder) as (process, address), sync_playwright() as play:
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.set_default_timeout(120_000)
        page.goto(address)
        settled(page)
        error = page.locator(".error").inner_text()
        took = [cancelled(page, after) for after in np.linspace(0.1, 6.0, cancels)]
        print(
            f"{cancels} cancelled refinements, click to page at rest: "
            f"p50 {np.median(took):.2f} s, most {max(took):.2f} s (limit 1)"
        )
        settled(page)
        print(f"click on Add to its bar and Cancel: {added(page):.2f} s (limit 3)")
        settled(page)
        error = page.locator(".error").inner_text()
        print(f"killed worker: message after {killed(page, process.pid):.2f} s", end="; ")
        page.get_by_role("button", name="Fit").click()
        settled(page)
        print(f"error before {error}, after a fit {page.locator('.error').inner_text()}")
        browser.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--cancels", type=int, default=10)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.folder or virtual_sensor(Path(temporary) / "sensor")
        measured(folder, options.cancels)


if __name__ == "__main__":
    main()
