"""Time and peak memory beside what one would reach for instead, all in one run.

    python benchmarks/speed.py                       the whole table
    python benchmarks/speed.py --quick --no-peers    ours and plain NumPy, fewer frames
    python benchmarks/speed.py --peers DIR           keep the peers' environments in DIR

Each case runs in a process of its own. getframes, pyxel-sim and emva1288 run in environments that
pip fills; one that cannot be installed, or does not run, is shown as such. Seconds are of the wall
clock; CPU seconds, which other work on the machine disturbs less, stand beside them. The tables
are Markdown; --json writes the numbers.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import venv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from speed_cases import TEN

CASES = Path(__file__).with_name("speed_cases.py")
PEERS = {
    "getframes": ["getframes"],
    "pyxel-sim": ["pyxel-sim"],
    "emva1288": ["emva1288", "numpy<2"],  # its release calls what NumPy 2 left out
}
PAPER = ["convolved_lognormal"]
# means and variances of the pixels, spectra along rows and columns, histograms and quantiles
EMVA1288 = ["level", "distribution", "pattern_spectrum", "time"]
TIMEOUT = 1800
Result = dict[str, Any]


def run(case: str, python: str = sys.executable, **arguments: Any) -> Result:
    """One case in a process of its own; {"failed": reason} where it does not run."""
    command = [python, str(CASES), case, json.dumps(arguments)]
    environment = os.environ | {"DNANALYZE_CACHE": "off"}
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=TIMEOUT, env=environment
        )
    except subprocess.TimeoutExpired:
        return {"failed": f"more than {TIMEOUT} s"}
    if done.returncode:
        return {"failed": (done.stderr.strip().splitlines() or ["died"])[-1][:120]}
    result: Result = json.loads(done.stdout.strip().splitlines()[-1])
    return result


def environment(name: str, folder: Path) -> str | None:
    """Python of an environment that holds the peer; None where pip could not install it."""
    home = folder / name
    python = home / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if not python.exists():
        venv.create(home, with_pip=True)
        command = [str(python), "-m", "pip", "install", "--quiet", *PEERS[name]]
        if subprocess.run(command, capture_output=True).returncode:
            return None
    return str(python)


def peer(case: str, name: str, folder: Path | None, **arguments: Any) -> Result:
    """A case in the peer's own environment."""
    if folder is None:
        return {"failed": "left out"}
    python = environment(name, folder)
    return run(case, python, **arguments) if python else {"failed": "does not install"}


def table(title: str, head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Markdown."""
    lines = [f"\n{title}\n", "| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def timed(label: str, result: Result, each: str = "seconds") -> list[str]:
    """A row: label, wall, CPU, peak memory."""
    if "failed" in result:
        return [label, result["failed"], "", ""]
    return [label, f"{result['seconds']:.3g}", f"{result['cpu']:.3g}", f"{result['peak_mib']:.0f}"]


def exponent(sizes: Sequence[float], results: Sequence[Result]) -> str:
    """Slope of log CPU time over log size."""
    known = [(s, r["cpu"]) for s, r in zip(sizes, results, strict=True) if "cpu" in r]
    if len(known) < 2:
        return ""
    x, y = np.log(np.array(known)).T
    return f"{np.polyfit(x, y, 1)[0]:.2f}"


def simulation(cores: int, folder: Path | None) -> dict[str, Result]:
    """One frame of 3840x2160, uint16."""
    return {
        f"dnanalyze, the paper's model, {cores} threads": run(
            "simulate_ours", effects=PAPER, threads=cores, frames=20
        ),
        "dnanalyze, the paper's model, 1 thread": run(
            "simulate_ours", effects=PAPER, threads=1, frames=20
        ),
        f"dnanalyze, ten effects, {cores} threads": run(
            "simulate_ours", effects=list(TEN), threads=cores, frames=12
        ),
        "the paper's formula in plain NumPy": run("simulate_numpy"),
        "getframes": peer("simulate_getframes", "getframes", folder),
        "pyxel-sim": peer("simulate_pyxel", "pyxel-sim", folder),
        "emva1288": peer("simulate_emva1288", "emva1288", folder),
    }


def analysis(cores: int, folder: Path | None) -> dict[str, Result]:
    """20 frames of 2048x2048 uint16."""
    ours = {"frames": 20, "shape": [2048, 2048]}
    return {
        f"dnanalyze, every statistic with its error, {cores} threads": run(
            "analyse_ours", threads=cores, **ours
        ),
        "dnanalyze, the same, 1 thread": run("analyse_ours", threads=1, **ours),
        f"dnanalyze, what holds emva1288's outputs: {', '.join(EMVA1288)}": run(
            "analyse_ours", threads=cores, families=EMVA1288, **ours
        ),
        "plain NumPy: means, variances, 2 spectra, quantiles": run("analyse_numpy", frames=20),
        "emva1288: sums, 2 spectrograms, 2 histograms": peer(
            "analyse_emva1288", "emva1288", folder, frames=20
        ),
        "bare stream of sums and squares": run("stream_bare", frames=20),
    }


def scaling(cores: int, quick: bool) -> list[tuple[str, list[float], list[Result]]]:
    """Time against frames, pixels and workers."""
    frames = [20, 60, 200] if quick else [20, 60, 200, 600, 2000]
    sides = [1024, 2048, 4096] if quick else [1024, 2048, 4096, 7168]
    workers = [1, 2, 4]
    small = [1024, 1024]
    return [
        (
            "frames of 1 Mpx",
            [float(n) for n in frames],
            [run("analyse_ours", frames=n, shape=small, threads=cores) for n in frames],
        ),
        (
            "Mpx of 8 frames",
            [s * s / 1e6 for s in sides],
            [run("analyse_ours", frames=8, shape=[s, s], threads=cores) for s in sides],
        ),
        (
            "workers, 20 frames of 4 Mpx",
            [float(n) for n in workers],
            [run("analyse_ours", frames=20, shape=[2048, 2048], threads=n) for n in workers],
        ),
        (
            "workers, one frame of the paper's model",
            [float(n) for n in workers],
            [run("simulate_ours", effects=PAPER, threads=n, frames=20) for n in workers],
        ),
    ]


def load() -> str:
    """How busy the machine is."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--peers", type=Path, help="folder of the peers' environments")
    parser.add_argument("--no-peers", action="store_true")
    parser.add_argument("--quick", action="store_true", help="fewer frames and pixels")
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    cores = cores or 1
    print(f"{platform.machine()}, {cores} processors, load {load()} at the start")
    with tempfile.TemporaryDirectory() as temporary:
        folder = None if asked.no_peers else (asked.peers or Path(temporary)).resolve()
        made = simulation(cores, folder)
        read = analysis(cores, folder)
    head = ("", "s", "CPU s", "peak MiB")
    print(table("One dark frame of 3840 x 2160", head, [timed(*r) for r in made.items()]))
    print(table("20 frames of 2048 x 2048, uint16", head, [timed(*r) for r in read.items()]))
    grown = scaling(cores, asked.quick)
    for title, sizes, results in grown:
        rows = [timed(f"{size:g}", result) for size, result in zip(sizes, results, strict=True)]
        print(table(f"Time against {title}", ("size", *head[1:]), rows))
        if not title.startswith("workers"):
            print(f"\nCPU time grows with the power {exponent(sizes, results)}.")
    bounds = run("limits")
    rows = [[k, f"{v:.3g}"] for k, v in bounds.items() if k != "peak_mib"]
    print(table("What limits, on one core", ("", "figure"), rows))
    compiled = run("first_use")
    print(
        table(
            "First use, nothing compiled yet",
            head,
            [timed("ten effects, all statistics", compiled)],
        )
    )
    print(f"\nload {load()} at the end")
    if asked.json:
        content = {
            "simulation": made,
            "analysis": read,
            "scaling": [{"title": t, "sizes": s, "results": r} for t, s, r in grown],
            "limits": bounds,
            "first_use": compiled,
        }
        asked.json.write_text(json.dumps(content, indent=1))


if __name__ == "__main__":
    main()
