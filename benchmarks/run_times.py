"""How long each command takes, by frame size: a table for docs/accuracy.md.

    python benchmarks/run_times.py [--sizes 256,512,1024,2048] [--frames 6] [--json times.jsonl]

The captures are those of ``dnanalyze demo`` at each size: 5 temperatures, column offsets hidden.
The table states the processor time of the command and of its helpers, which depends less on what
else the machine does than the elapsed time; ``--json`` writes both.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.demo import draw_sensor, generate, write_folder

COMMANDS = {
    "inspect": [],
    "analyze": ["--no-cache"],
    "compare": ["--no-cache"],
    "detect": [],
    "refine": ["--no-cache", "--time-limit", "300", "-o", "model.yaml", "--report", "page.html"],
}


def captures(folder: Path, size: int, frames: int) -> Path:
    """The sensor of the demo with square frames."""
    made = generate(
        draw_sensor(np.random.default_rng(1)),
        {"column_fpn": "middling"},
        (size, size),
        frames=frames,
        seed=1,
    )
    return write_folder(made, folder / f"frames-{size}")


def timed(command: str, folder: Path, options: list[str], cwd: Path) -> dict[str, float]:
    """Elapsed and processor time of one run, s."""
    import resource

    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "dnanalyze", command, str(folder), *options, "--quiet"],
        cwd=cwd, check=True, stdout=subprocess.DEVNULL,
        env=os.environ | {"XDG_CACHE_HOME": str(cwd / "cache")},
    )  # fmt: skip
    elapsed = time.perf_counter() - begun
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return {
        "elapsed_s": elapsed,
        "cpu_s": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
    }


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--sizes", default="256,512,1024,2048")
    parser.add_argument("--frames", type=int, default=6)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        timed("refine", captures(work, 64, 2), COMMANDS["refine"], work)  # compiles the loops
        for size in map(int, options.sizes.split(",")):
            folder = captures(work, size, options.frames)
            for command, more in COMMANDS.items():
                rows.append(
                    {"size": size, "command": command, **timed(command, folder, more, work)}
                )
                if options.json:
                    options.json.write_text("".join(json.dumps(r) + "\n" for r in rows))
    print("| frames of | " + " | ".join(f"`{c}`" for c in COMMANDS) + " |")
    print("|---" * (len(COMMANDS) + 1) + "|")
    for size in dict.fromkeys(r["size"] for r in rows):
        cells = [f"{r['cpu_s']:.0f}" for r in rows if r["size"] == size]
        print(f"| {size} × {size} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
