"""Whether `refine` names the same effects whatever the seed, and with one frame left out.

    python benchmarks/stability.py FOLDER ... [--seeds 5] [--time-limit SECONDS] [--json OUT.jsonl]

Each folder is refined with as many seeds of the simulated sensor, and once with the last frame of
every operating point left out. The table gives the names, in how many of the runs each was added,
its least confidence, and the range of the model error. A name that is not in all runs deserves a
confidence of no more than its share.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import dnanalyze
from dnanalyze.diagnosis.refine import refine_on
from dnanalyze.loaders.captures import CaptureSet


def variants(captures: CaptureSet, seeds: int) -> Iterator[tuple[str, CaptureSet, int]]:
    """Name, captures and seed of each run."""
    for seed in range(seeds):
        yield f"seed {seed}", captures, seed
    fewer = tuple(
        replace(s, frames=s.frames[: max(1, len(s.frames) - 1)]) for s in captures.settings
    )
    yield "one frame fewer", replace(captures, settings=fewer), 0


def run(captures: CaptureSet, seed: int, budget: float | None) -> dict[str, Any]:
    """The effects beside the baseline with their confidence, the verdict and the error."""
    begun = time.perf_counter()
    found = refine_on(captures, seed=seed, budget=budget)
    added = {s.added: s.confidence for s in found.steps if s.added and s.confidence is not None}
    return {
        "effects": {name: added.get(name) for name in found.model.names if name in added},
        "verdict": found.verdict,
        "error": found.steps[-1].error,
        "finished": found.finished,
        "seconds": time.perf_counter() - begun,
    }


def line(folder: str, runs: list[dict[str, Any]]) -> str:
    """A row of the table."""
    names = sorted({name for r in runs for name in r["effects"]})
    told = []
    for name in names:
        sure = [r["effects"][name] for r in runs if name in r["effects"]]
        told.append(f"{name} {len(sure)}/{len(runs)} ({min(sure):.2g})")
    errors = [r["error"] for r in runs]
    verdicts = ", ".join(sorted({r["verdict"] for r in runs}))
    sets = [tuple(sorted(r["effects"])) for r in runs]
    most = max(sets.count(s) for s in sets)
    return (
        f"| {folder} | {'; '.join(told) or 'none'} | {most} of {len(runs)} | {verdicts} | "
        f"{min(errors):.3g} to {max(errors):.3g} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--time-limit", type=float, help="seconds of each run")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    print("| captures | added: in how many runs (least confidence) | same set | verdict | error |")
    print("|---|---|---|---|---|", flush=True)
    for folder in options.folders:
        captures, runs = dnanalyze.load(folder), []
        for name, seen, seed in variants(captures, options.seeds):
            runs.append(run(seen, seed, options.time_limit))
            if options.json:
                with options.json.open("a", encoding="utf-8") as out:
                    out.write(json.dumps({"folder": folder.name, "run": name} | runs[-1]) + "\n")
        print(line(folder.name, runs), flush=True)


if __name__ == "__main__":
    main()
