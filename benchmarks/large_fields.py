"""Structures with a place on a field of 24 megapixels: are they found, in what time and memory?

    python benchmarks/large_fields.py [--times 3] [--cases corner_glow,...] [--json rows.jsonl]

The frames are drawn by NumPy alone: 4000 x 6000 pixels, three temperatures, each with another
exposure, five frames each, ordinary noise and one structure. Glow is proportional to the exposure,
else it is no other than columns that settle. The strength is `--times` the detection limit of the
effect that makes the structure, which `diagnose` states for a sensor of the same size without it;
of a single column no limit is stated, and it is 1 DN.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import dnanalyze

SHAPE = (4000, 6000)
SETTINGS = ((15.0, 0.4), (35.0, 0.2), (55.0, 0.1))  # C, s
FRAMES = 5
LEVEL, READ, OFFSETS = 64.0, 2.5, 0.8  # DN
GAIN = 0.5  # DN/e-
LONGEST_DIAGNOSIS = 400.0  # s

Structure = Callable[[np.ndarray, np.ndarray, float], np.ndarray]  # of rows, columns, exposure


def _corner(y: np.ndarray, x: np.ndarray, exposure: float) -> np.ndarray:
    return exposure / 0.1 * np.exp(-np.hypot(y, x) / 500.0)


def _edge(y: np.ndarray, x: np.ndarray, exposure: float) -> np.ndarray:
    return exposure / 0.1 * np.exp(-(SHAPE[1] - 1 - x) / 300.0) * np.ones_like(y)


def _column(y: np.ndarray, x: np.ndarray, exposure: float) -> np.ndarray:
    return (x == 4321) * np.ones_like(y)


def _tap(y: np.ndarray, x: np.ndarray, exposure: float) -> np.ndarray:
    return (x >= SHAPE[1] // 2) * np.ones_like(y)


def _stripe(y: np.ndarray, x: np.ndarray, exposure: float) -> np.ndarray:
    return (y < 24) * np.ones_like(x)


GLOWS = _corner, _edge

# The structure, the effect whose limit is taken, and the effects that are right.
CASES: dict[str, tuple[Structure, str, tuple[str, ...]]] = {
    "corner_glow": (_corner, "amp_glow", ("amp_glow",)),
    "edge_glow": (_edge, "amp_glow", ("amp_glow",)),
    "defect_column": (_column, "", ("defect_lines",)),
    "tap_boundary": (_tap, "column_taps", ("column_taps",)),
    "border_stripe": (_stripe, "amp_glow", ("column_taps", "defect_lines", "row_fpn")),
}


def draw(folder: Path, structure: Structure | None, strength: float, seed: int = 0) -> None:
    """Write the frames of a sensor as NumPy files; temperatures are in their names."""
    draw_seed = np.random.default_rng(seed)
    offsets = draw_seed.standard_normal(SHAPE, np.float32) * np.float32(OFFSETS)
    current = np.exp(0.4 * draw_seed.standard_normal(SHAPE, np.float32))  # 1 e- in the median
    y, x = np.ogrid[: SHAPE[0], : SHAPE[1]]
    for temperature, exposure in SETTINGS:
        rate = 20.0 * 2.0 ** ((temperature - 15.0) / 8.0)  # e-/s
        charge = current * np.float32(rate * exposure)
        mean = np.float32(LEVEL) + offsets
        if structure is not None:
            added = np.float32(strength) * structure(y, x, exposure).astype(np.float32)
            if structure in GLOWS:  # charge, with its shot noise
                charge += added / np.float32(GAIN)
            else:
                mean += added
        for n in range(FRAMES):
            frame = np.random.default_rng([seed, n, int(temperature)])
            dark = np.float32(GAIN) * frame.poisson(charge).astype(np.float32)
            noise = np.float32(READ) * frame.standard_normal(SHAPE, np.float32)
            codes = np.clip(np.rint(mean + dark + noise), 0, 4095).astype(np.uint16)
            np.save(folder / f"dark_{temperature:.0f}C_{exposure}s_{n}.npy", codes)


def run(folder: Path, what: str) -> dict[str, Any]:
    """The limits or the refinement of a folder, by a process of its own."""
    command = [sys.executable, __file__, f"--{what}", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout.splitlines()[-1]))


def limits(folder: Path) -> dict[str, Any]:
    """The detection limit of every effect."""
    found = dnanalyze.diagnose(dnanalyze.load(folder), budget=LONGEST_DIAGNOSIS)
    return {name: limit.value for name, limit in found.detection_limits.items()}


def refinement(folder: Path, budget: float) -> dict[str, Any]:
    """What `refine` finds in a time, with what it takes."""
    begun = time.perf_counter()
    found = dnanalyze.refine(dnanalyze.load(folder), budget=budget)
    seconds = time.perf_counter() - begun
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    return {
        "effects": found.effects,
        "verdict": found.verdict,
        "errors": [s.error for s in found.steps],
        "seconds": seconds,
        "memory_gib": memory,
        "coverage": str(found.coverage),
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--times", type=float, default=3.0)
    parser.add_argument("--cases", default=",".join(CASES))
    parser.add_argument("--json", type=Path)
    parser.add_argument("--budget", type=float, default=180.0, help="seconds of a refinement")
    parser.add_argument("--limits", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--refinement", type=Path, help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.limits:
        print(json.dumps(limits(args.limits)))
    elif args.refinement:
        print(json.dumps(refinement(args.refinement, args.budget)))
    else:
        study(args.cases.split(","), args.times, args.json)


def study(cases: Sequence[str], times: float, rows: Path | None) -> None:
    """Draw and judge every case."""
    with tempfile.TemporaryDirectory() as at:
        draw(Path(at), None, 0.0)
        plain = run(Path(at), "limits")
    for name in cases:
        structure, effect, right = CASES[name]
        with tempfile.TemporaryDirectory() as at:
            strength = times * plain[effect] if effect else 1.0
            draw(Path(at), structure, strength, seed=1)
            seen = run(Path(at), "refinement")
        found = any(e in right for e in seen["effects"])
        print(
            f"{name}: {strength:.3g} DN, found {found}: {seen['effects']}, "
            f"{seen['verdict']}, {seen['seconds']:.0f} s, {seen['memory_gib']:.2f} GiB",
            flush=True,
        )
        if rows:
            with rows.open("a") as file:
                row = {"case": name, "strength": strength, "found": found, **seen}
                file.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    main()
