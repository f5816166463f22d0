"""Latency and memory of the workbench, measured in a headless Chromium.

    python benchmarks/workbench.py [FOLDER ...] [--moves 50] [--long 500] [--busy]
    python benchmarks/workbench.py --opening FOLDER ...

A folder is one of captures, or a word: `demo` is the sensor of `--demo`, `large` one of 24 million
pixels at 3 temperatures x 5 frames, `middle` (the default) one of 5 temperatures x 8 frames x 512 x
512. A move is a key pressed on a slider; it ends when the browser has drawn the new curve; the
first series begins with the first move after the page is opened. With --opening: the times from the
address to paint, frames, first error and fitted error, with an empty cache of statistics and with a
filled one; in brackets the processor time of server and worker. With --busy another process keeps
one processor busy. Every line ends with the load of the machine, of the last minute. Needs the
extra `workbench`, Playwright and Debian's chromium.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

RUN = "from dnanalyze_cli.main import run; run()"
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip
SERIES = 3  # of moves: one alone varies with what else the machine does
REST_S = 0.3  # the page waits so long after the last move
MOVES = """async (handle, [count, pause]) => {
  const doc = Bokeh.documents.find((d) => d.get_model_by_name("curve of present model"));
  const took = [];
  for (let i = 0; i < count; i++) {
    const source = doc.get_model_by_name("curve of present model");
    const begun = performance.now();
    const drawn = new Promise((resolve) => {
      const slot = () => {
        source.properties.data.change.disconnect(slot);
        requestAnimationFrame(() => requestAnimationFrame(resolve));
      };
      source.properties.data.change.connect(slot);
      setTimeout(resolve, 5000);
    });
    const key = i % 10 < 5 ? "ArrowRight" : "ArrowLeft";  // within the slider's range
    handle.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
    await drawn;
    took.push(performance.now() - begun);
    await new Promise((resolve) => setTimeout(resolve, pause));
  }
  return took;
}"""

FRAMES = """() => window.Bokeh?.documents.some(
  (d) => d.get_model_by_name("image of measured")?.data.image.length > 0)"""


def virtual_sensor(folder: Path) -> Path:
    """5 temperatures x 8 frames x 512 x 512 with column FPN."""
    from dnanalyze.demo import draw_sensor, generate, write_folder

    sensor = draw_sensor(np.random.default_rng(1))
    made = generate(sensor, {"column_fpn": "middling"}, (512, 512), frames=8, seed=1)
    return write_folder(made, folder)


def large_sensor(folder: Path) -> Path:
    """3 temperatures x 5 frames x 4000 x 6000 of the sample model with column FPN."""
    model = folder.with_suffix(".yaml")
    sample = Path(__file__).parents[1] / "sample_configs" / "model.yaml"
    text = sample.read_text(encoding="utf-8")
    model.write_text(text + "- column_fpn: {sigma: 0.25}\n", encoding="utf-8")
    command = ["simulate", str(folder), "--model", str(model), "--shape", "4000x6000"]
    command += ["--temperatures", "25,45,65", "--exposure", "0.05", "--gain", "1"]
    command += ["--frames", "5", "--quiet"]
    subprocess.run([sys.executable, "-c", RUN, *command], check=True, stdout=subprocess.DEVNULL)
    return folder


VIRTUAL = {"middle": virtual_sensor, "large": large_sensor}


def load() -> str:
    """Mean number of processes that ran or waited for a processor in the last minute."""
    return f"; load {os.getloadavg()[0]:.1f}"


@contextmanager
def busy(wanted: bool) -> Iterator[None]:
    """One processor kept busy meanwhile, where that is wanted."""
    spinning = subprocess.Popen([sys.executable, "-c", "while True: pass"]) if wanted else None
    try:
        yield
    finally:
        if spinning is not None:
            spinning.kill()
            spinning.wait()


def memory_mib(pid: int) -> float:
    """Resident memory of a process."""
    text = Path(f"/proc/{pid}/status").read_text()
    return int(re.search(r"VmRSS:\s+(\d+)", text).group(1)) / 1024  # type: ignore[union-attr]


def processor_s(pid: int) -> float:
    """Processor time of a process and of those that it has begun: other work scarcely alters it."""
    found = 0.0
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = path.read_text().rpartition(")")[2].split()
        except OSError:  # it has just ended
            continue
        if pid in (int(path.parent.name), int(fields[1])):
            ticks = 4 if pid == int(path.parent.name) else 2  # its own: with ended processes too
            found += sum(map(int, fields[11 : 11 + ticks])) / os.sysconf("SC_CLK_TCK")
    return found


def settled(page: Any, limit_s: float = 300.0) -> None:
    """Wait until the full error shows and no task is under way."""
    fitted = page.locator("option").filter(has_text="model, fitted")
    fitted.first.wait_for(state="attached", timeout=1000 * limit_s)
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        shown = page.locator(".error")
        if (
            shown.count()
            and re.fullmatch(r"[\d.]+", shown.inner_text())
            and page.get_by_role("button", name="Diagnose").is_enabled()
        ):
            return
        page.wait_for_timeout(20)
    raise SystemExit("the page never came to rest")


def drawing(page: Any) -> Any:
    """The first slider of which every move alters the open figure: some are of other points."""
    sliders = page.locator(".parameter").locator("[role=slider]")
    for number in range(1, sliders.count()):
        found = sliders.nth(number)
        took = found.evaluate(MOVES, [4, 0])
        settled(page)
        if max(took) < min(took) + 1000 * REST_S:  # none drew its curve at rest only
            return found
    raise SystemExit("no slider alters the open figure")


@contextmanager
def served(folder: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The server's process and the address of its page, while it runs."""
    where = "--demo" if folder == Path("demo") else str(folder)
    process = subprocess.Popen(
        [sys.executable, "-c", RUN, "workbench", where, "--no-browser"],
        stdout=subprocess.PIPE, text=True, env=os.environ | {"PYTHONUNBUFFERED": "1"},
    )  # fmt: skip
    assert process.stdout is not None
    try:
        yield process, process.stdout.readline().split()[0]
    finally:
        process.terminate()
        process.wait(20)
        process.stdout.close()


def measured(folder: Path, moves: int, long: int, pictures: Path | None) -> None:
    """Print every figure."""
    from playwright.sync_api import sync_playwright

    with served(folder) as (process, address), sync_playwright() as play:
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        context = browser.new_context(viewport={"width": 1440, "height": 900})
        context.set_default_timeout(300_000)
        page = context.new_page()
        page.goto(address)
        settled(page)  # statistics, compiled loops and scripts are in the caches now
        page.close()
        page = context.new_page()
        begun = time.perf_counter()
        page.goto(address)
        page.get_by_text("Where it fails").wait_for()
        print(f"first paint, warm cache: {time.perf_counter() - begun:.2f} s (limit 3){load()}")
        settled(page)
        handle = drawing(page)
        for _ in range(SERIES):
            spent = processor_s(process.pid)
            took = handle.evaluate(MOVES, [moves, 60])
            p50, p95 = np.percentile(took, [50, 95])
            print(
                f"{moves} slider moves, key to drawn curve: p50 {p50:.0f} ms, "
                f"p95 {p95:.0f} ms (limit 250); processor time of server and worker "
                f"{processor_s(process.pid) - spent:.1f} s{load()}",
                flush=True,
            )
            settled(page)
        rests: dict[str, list[float]] = {"full": [], "exact": []}
        for _ in range(10):  # all to the right: the errors of earlier values are known
            handle.evaluate(MOVES, [1, 0])
            begun = time.perf_counter()
            page.locator(".error.preview").wait_for(timeout=20000)
            page.locator(".error.full, .error.exact").wait_for(timeout=60000)
            rests["full"].append(time.perf_counter() - begun)
            settled(page)
            rests["exact"].append(time.perf_counter() - begun)
        for name, took in rests.items():
            print(
                f"{name} error after rest: p50 {np.median(took):.2f} s, most {max(took):.2f} s "
                f"({REST_S:g} s of it the wait; limit of the full one 1){load()}",
                flush=True,
            )
        if pictures is not None:
            page.screenshot(path=str(pictures / "workbench.png"))
        before = memory_mib(process.pid)
        handle.evaluate(MOVES, [long, 10])
        settled(page)
        after = memory_mib(process.pid)
        print(
            f"server's memory: {before:.0f} MiB, {after:.0f} MiB after {long} moves more "
            f"(limit 1536){load()}"
        )
        alone = memory_mib(process.pid)
        tabs = [context.new_page() for _ in range(2)]
        for tab in tabs:
            tab.goto(address)
            settled(tab)
        print(
            f"server's memory: {alone:.0f} MiB with one page, {memory_mib(process.pid):.0f} MiB "
            "with three (limit 1.2 times)"
        )
        browser.close()


def opened(folder: Path) -> None:
    """Print the times from a page's address to what it shows."""
    from playwright.sync_api import sync_playwright

    with (
        tempfile.TemporaryDirectory() as cache,
        sync_playwright() as play,
        patched(DNANALYZE_CACHE=cache),
    ):
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        for state in ("empty", "filled"):
            with served(folder) as (process, address):
                page = browser.new_page(viewport={"width": 1440, "height": 900})
                page.set_default_timeout(300_000)
                begun = time.perf_counter()
                page.goto(address)
                took: dict[str, tuple[float, float]] = {}
                spent = processor_s(process.pid)
                fitted = page.locator("option").filter(has_text="model, fitted")
                for what, shown in (
                    ("paint", page.get_by_text("Where it fails")),
                    ("frames", None),
                    ("first error", page.locator(".error")),
                    ("fitted", fitted),
                    ("exact", page.locator(".error.exact")),
                ):
                    if shown is None:
                        page.wait_for_function(FRAMES)
                    else:
                        shown.first.wait_for(state="attached")
                    took[what] = time.perf_counter() - begun, processor_s(process.pid) - spent
                page.close()
            times = ", ".join(f"{k} {v:.1f} s ({cpu:.1f})" for k, (v, cpu) in took.items())
            print(f"{folder.name}, cache {state}: {times}{load()}", flush=True)
        browser.close()


@contextmanager
def patched(**variables: str) -> Iterator[None]:
    """Environment variables of the servers begun here."""
    before = dict(os.environ)
    os.environ.update(variables)
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path, metavar="FOLDER")
    parser.add_argument("--moves", type=int, default=50)
    parser.add_argument("--long", type=int, default=500)
    parser.add_argument("--screenshot", type=Path, metavar="DIR")
    parser.add_argument("--opening", action="store_true", help="times of opening alone")
    parser.add_argument("--busy", action="store_true", help="beside one busy process")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary, busy(options.busy):
        for named in options.folders or [Path("middle")]:
            make = VIRTUAL.get(str(named))
            folder = named if make is None else make(Path(temporary) / named)
            if options.opening:
                opened(folder)
            else:
                print(f"{folder.name}:")
                measured(folder, options.moves, options.long, options.screenshot)


if __name__ == "__main__":
    main()
