"""What `refine` makes of real captures: error, effects, gain and energy beside direct values.

    python benchmarks/real_captures.py FOLDER... [--time-limit 300] [--jobs 2] [--json rows.jsonl]

One row a folder: the model error at the start and at the end, the steps that raised it, the
effects added with their confidence, system gain and activation energy of the model beside those of
the frames and of the file headers, how many dark signals agree, what the classifier says, and the
seconds. Quantities that the frames do not determine are left empty.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import dnanalyze
from dnanalyze.errors import InputError
from dnanalyze.fitting.agreement import Agreement

COLUMNS = (
    "captures", "model error", "steps that raise it", "added (confidence)", "verdict",
    "system gain of the frames, recorded; model, DN/e-",
    "activation energy of the frames; model, eV", "dark signals that agree",
    "AUC; control", "seconds",
)  # fmt: skip


def row(folder: Path, budget: float) -> dict[str, Any]:
    """One folder refined."""
    begun = time.perf_counter()
    try:
        captures = dnanalyze.load(folder)
        found = dnanalyze.refine(captures, budget=budget)
    except InputError as error:
        return {"captures": folder.name, "failed": str(error)}
    seconds = time.perf_counter() - begun
    told = found.classification
    errors = [s.error for s in found.steps]
    signals = [a for a in found.direct if a.quantity == "dark signal"]
    return {
        "captures": folder.name,
        "errors": errors,
        "rising": [
            str(s.added)
            for s, before in zip(found.steps[1:], errors, strict=False)
            if s.error > before
        ],
        "added": {
            s.added: s.confidence
            for s in found.steps
            if s.added in found.effects and s.confidence is not None
        },
        "verdict": found.verdict,
        "timed_out": found.timed_out,
        "unexplained": found.unexplained,
        "gains": [_plain(a) for a in found.direct if a.quantity.startswith("system gain")],
        "energies": [_plain(a) for a in found.direct if a.unit == "eV"],
        "signals": [sum(a.kept for a in signals), len(signals)],
        "worst_signal": max((_plain(a) for a in signals), key=_off, default=None),
        "auc": None if told is None else told.auc,
        "control": None if told is None else told.control,
        "tells": None if told is None else told.tells,
        "seconds": seconds,
    }


def _plain(found: Agreement) -> dict[str, Any]:
    return {
        "quantity": found.quantity,
        "point": None if found.point is None else found.point.label(),
        "direct": found.direct,
        "se": found.error,
        "model": found.model,
        "kept": found.kept,
    }


def _off(plain: dict[str, Any]) -> float:
    return abs(plain["model"] - plain["direct"]) / max(plain["se"], 1e-9)


def cells(made: dict[str, Any]) -> Sequence[str]:
    """A row as text."""
    if "failed" in made:
        return (made["captures"], made["failed"], *[""] * (len(COLUMNS) - 2))
    added = [f"{n} ({c:.2f})" for n, c in made["added"].items()]
    own = next((g["model"] for g in made["gains"]), None)
    gains = [f"{g['direct']:.3g} ± {g['se']:.1g}" for g in made["gains"]]
    energies = [f"{e['direct']:.2f} ± {e['se']:.1g}; {e['model']:.2f}" for e in made["energies"]]
    kept, count = made["signals"]
    return (
        made["captures"],
        f"{made['errors'][0]:.3g} to {made['errors'][-1]:.3g}",
        ", ".join(made["rising"]),
        ", ".join(added),
        made["verdict"] + (" (time limit)" if made["timed_out"] else ""),
        "" if own is None else f"{', '.join(gains)}; {own:.3g}",
        ", ".join(energies),
        f"{kept} of {count}" if count else "",
        "" if made["auc"] is None else f"{made['auc']:.2f}; {made['control']:.2f}",
        f"{made['seconds']:.0f}",
    )


def table(rows: Iterable[dict[str, Any]]) -> str:
    """Markdown."""
    lines = [COLUMNS, tuple("---" for _ in COLUMNS), *map(cells, rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--time-limit", type=float, default=300.0, help="seconds a folder")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path, help="one line a folder")
    asked = parser.parse_args()
    rows = []
    with ProcessPoolExecutor(asked.jobs) as pool:
        for made in pool.map(partial(row, budget=asked.time_limit), asked.folders):
            rows.append(made)
            if asked.json:
                with asked.json.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps(made, default=float) + "\n")
    print(table(rows))


if __name__ == "__main__":
    main()
