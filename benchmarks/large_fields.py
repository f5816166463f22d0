"""Structures with a place on a field of 24 megapixels: are they found, in what time and memory?

    python benchmarks/large_fields.py [--times 3] [--cases corner_glow,...] [--json rows.jsonl]

The frames are drawn by NumPy alone: 4000 x 6000 pixels, three temperatures, five frames each,
ordinary noise and one structure. Its strength is `--times` the detection limit of the effect that
makes it, which `diagnose` states for a sensor of the same size without it.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

SHAPE = (4000, 6000)
TEMPERATURES = (15.0, 35.0, 55.0)
FRAMES = 5
LEVEL, READ, OFFSETS = 64.0, 2.5, 0.8  # DN

Structure = Callable[[np.ndarray, np.ndarray, float], np.ndarray]


def _corner(y: np.ndarray, x: np.ndarray, strength: float) -> np.ndarray:
    return strength * np.exp(-np.hypot(y, x) / 500.0)


def _edge(y: np.ndarray, x: np.ndarray, strength: float) -> np.ndarray:
    return strength * np.exp(-(SHAPE[1] - 1 - x) / 300.0) * np.ones_like(y)


def _column(y: np.ndarray, x: np.ndarray, strength: float) -> np.ndarray:
    return strength * (x == 4321) * np.ones_like(y)


def _tap(y: np.ndarray, x: np.ndarray, strength: float) -> np.ndarray:
    return strength * (x >= SHAPE[1] // 2) * np.ones_like(y)


def _stripe(y: np.ndarray, x: np.ndarray, strength: float) -> np.ndarray:
    return strength * (y < 24) * np.ones_like(x)


# The structure, the effect whose limit is taken, and the effects that are right.
CASES: dict[str, tuple[Structure, str, tuple[str, ...]]] = {
    "corner_glow": (_corner, "amp_glow", ("amp_glow",)),
    "edge_glow": (_edge, "amp_glow", ("amp_glow",)),
    "defect_column": (_column, "defect_lines", ("defect_lines",)),
    "tap_boundary": (_tap, "column_taps", ("column_taps",)),
    "border_stripe": (_stripe, "amp_glow", ("amp_glow", "defect_lines", "row_fpn")),
}


def draw(folder: Path, structure: Structure | None, strength: float, seed: int = 0) -> None:
    """Write the frames of a sensor as NumPy files; temperatures are in their names."""
    draw_seed = np.random.default_rng(seed)
    offsets = draw_seed.standard_normal(SHAPE, np.float32) * np.float32(OFFSETS)
    current = np.exp(0.4 * draw_seed.standard_normal(SHAPE, np.float32))  # 1 e- in the median
    y, x = np.ogrid[: SHAPE[0], : SHAPE[1]]
    for temperature in TEMPERATURES:
        charge = current * np.float32(2.0 * 2.0 ** ((temperature - 15.0) / 8.0))
        mean = np.float32(LEVEL) + offsets
        if structure is not None:
            mean = mean + structure(y, x, strength).astype(np.float32)
        for n in range(FRAMES):
            frame = np.random.default_rng([seed, n, int(temperature)])
            # shot noise by its normal limit; the square root keeps small charges positive
            root = np.sqrt(charge) + 0.5 * frame.standard_normal(SHAPE, np.float32)
            dark = np.float32(0.5) * root * root
            noise = np.float32(READ) * frame.standard_normal(SHAPE, np.float32)
            codes = np.clip(np.rint(mean + dark + noise), 0, 4095).astype(np.uint16)
            np.save(folder / f"dark_{temperature:.0f}C_0.1s_{n}.npy", codes)


def run(folder: Path, effect: str = "") -> dict[str, object]:
    """What the package says of a folder, in a process of its own; with an effect, its limit."""
    command = [sys.executable, __file__, "--judge", str(folder), "--limit-of", effect]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout.splitlines()[-1]))


def judge(folder: Path, effect: str) -> dict[str, object]:
    """`refine` of a folder, or the detection limit of an effect in it."""
    import dnanalyze

    begun = time.perf_counter()
    first: list[float] = []
    captures = dnanalyze.load(folder)
    if effect:
        found = dnanalyze.diagnose(captures, budget=400.0)
        limit = found.detection_limits.get(effect)
        return {"limit": None if limit is None else limit.value}
    refined = dnanalyze.refine(
        captures, budget=180.0, progress=lambda *_: first.append(time.perf_counter() - begun)
    )
    children, own = (
        resource.getrusage(who).ru_maxrss / 2**20
        for who in (resource.RUSAGE_CHILDREN, resource.RUSAGE_SELF)
    )
    return {
        "effects": refined.effects,
        "verdict": refined.verdict,
        "errors": [s.error for s in refined.steps],
        "seconds": time.perf_counter() - begun,
        "memory_gib": own + children,
        "coverage": str(refined.coverage),
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--times", type=float, default=3.0)
    parser.add_argument("--cases", default=",".join(CASES))
    parser.add_argument("--json", type=Path)
    parser.add_argument("--judge", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--limit-of", default="", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.judge:
        print(json.dumps(judge(args.judge, args.limit_of)))
        return
    with tempfile.TemporaryDirectory() as at:
        draw(Path(at), None, 0.0)
        plain = {e: run(Path(at), e)["limit"] for e in {CASES[n][1] for n in args.cases.split(",")}}
    for name in args.cases.split(","):
        structure, effect, right = CASES[name]
        limit = plain[effect]
        if limit is None:
            print(f"{name}: no limit is stated")
            continue
        with tempfile.TemporaryDirectory() as at:
            draw(Path(at), structure, args.times * float(limit), seed=1)
            seen = run(Path(at))
        found = any(e in right for e in seen["effects"])
        row = {"case": name, "limit": limit, "found": found, **seen}
        print(
            f"{name}: {args.times:g} x {limit:.3g} DN, found {found}: {seen['effects']}, "
            f"{seen['verdict']}, {seen['seconds']:.0f} s, {seen['memory_gib']:.2f} GiB"
        )
        if args.json:
            with args.json.open("a") as file:
                file.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    main()
