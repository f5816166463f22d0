"""Whether `refine` gives the same answer whatever the processor: names, verdicts, errors.

    python benchmarks/same_answers.py FOLDER ... [--only native --only generic] [--jobs 2]

Each folder is refined once as this machine does by itself and once for each way to let it compute
as another would: compiled loops for x86-64 without extensions, and for Haswell; NumPy without
AVX-512; OpenBLAS as on Haswell. The table is Markdown; the exit code is 1 where a name or a
verdict differs, or an error by more than 1 %.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

NO_AVX512 = "AVX512F,AVX512CD,AVX512_SKX,AVX512_CLX,AVX512_CNL,AVX512_ICL,AVX512_SPR,X86_V4"
WAYS = {
    "native": {},
    "generic": {"NUMBA_CPU_NAME": "generic"},
    "haswell": {"NUMBA_CPU_NAME": "haswell"},
    "numpy without AVX-512": {"NPY_DISABLE_CPU_FEATURES": NO_AVX512},
    "BLAS of Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
}
WITHIN = 0.01  # of an error
Answer = dict[str, Any]


def refined(folder: Path, way: str, compiled: Path) -> Answer:
    """What `refine` says of a folder; {"failed": text} where it ends otherwise."""
    out = compiled / f"{way}-{folder.name}.json".replace(" ", "_")
    environment = os.environ | {"DNANALYZE_CACHE": "off"} | WAYS[way]
    if "NUMBA_CPU_NAME" in WAYS[way]:
        environment["NUMBA_CACHE_DIR"] = str(compiled / way)
    model = out.with_suffix(".yaml")
    call = "from dnanalyze_cli.main import run; run()"
    arguments = ["refine", str(folder), "-o", str(model), "--json", str(out), "--quiet"]
    done = subprocess.run(
        [sys.executable, "-c", call, *arguments], capture_output=True, text=True, env=environment
    )
    if done.returncode:
        return {"failed": (done.stderr.strip().splitlines() or ["died"])[-1]}
    answer = json.loads(out.read_text())
    names = [s["added"] or f"-{s.get('removed', '')}" for s in answer["steps"][1:]]
    errors = [s["error"] for s in answer["steps"]]
    return {"names": names, "verdict": answer["verdict"], "errors": errors}


def apart(one: Answer, other: Answer) -> float | None:
    """Largest relative difference of the errors, step by step; None where the answers differ."""
    same = all(one.get(k) == other.get(k) for k in ("names", "verdict"))
    if not same or "failed" in one or len(one["errors"]) != len(other["errors"]):
        return None
    return max(abs(a / b - 1) for a, b in zip(one["errors"], other["errors"], strict=True))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--only", action="append", choices=list(WAYS), help="these ways alone")
    parser.add_argument("--jobs", type=int, default=1, help="folders at a time")
    options = parser.parse_args()
    ways = options.only or list(WAYS)
    print(f"| folder | names | verdict | error | {' | '.join(ways[1:])} |", flush=True)
    print(f"|---|---|---|---|{'---|' * (len(ways) - 1)}", flush=True)
    failed = False
    with tempfile.TemporaryDirectory() as compiled, ThreadPoolExecutor(options.jobs) as pool:

        def row(folder: Path) -> list[Answer]:
            return [refined(folder, way, Path(compiled)) for way in ways]

        for folder, answers in zip(options.folders, pool.map(row, options.folders), strict=True):
            first, *others = answers
            if "failed" in first:
                print(f"| {folder.name} | {first['failed']} |", flush=True)
                failed = True
                continue
            cells = []
            for other in others:
                off = apart(first, other)
                failed |= off is None or off > WITHIN
                cells.append("**other answer**" if off is None else f"{off:.1e}" if off else "same")
            told = ", ".join(first["names"]), first["verdict"], f"{first['errors'][-1]:.4g}"
            print(f"| {' | '.join([folder.name, *told, *cells])} |", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
