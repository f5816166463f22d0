"""A case as an ordinary folder of captures, and its truth beside it."""

from __future__ import annotations

import csv
import json
import os
import shutil
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from third_party.case import Case, Drawn, Point


def folder_of(root: Path, case: Case) -> Path:
    """Where a case lies."""
    return root / case.key


def truth_file(folder: Path) -> Path:
    """Beside the folder, where nothing that reads captures looks."""
    return folder.with_name(folder.name + ".truth.json")


def write(case: Case, drawn: Drawn, root: Path) -> Path:
    """TIFF files ``T+025C/dark_000.tif`` with ``manifest.csv``; the whole folder or nothing."""
    import tifffile

    folder = folder_of(root, case)
    draft = folder.with_name(f".{folder.name}.{os.getpid()}")
    shutil.rmtree(draft, ignore_errors=True)
    draft.mkdir(parents=True)
    rows = []
    for point, stack in sorted(drawn.stacks.items()):
        for n, frame in enumerate(stack):
            name = f"T{point.temperature_c:+06.1f}C_{point.exposure_s:g}s/dark_{n:03d}.tif"
            (draft / name).parent.mkdir(exist_ok=True)
            tifffile.imwrite(draft / name, np.asarray(frame, np.uint16))
            rows.append([name, point.temperature_c, point.exposure_s])
    with (draft / "manifest.csv").open("w", newline="", encoding="utf-8") as stream:
        csv.writer(stream).writerows([["file", "temperature_c", "exposure_s"], *rows])
    truth = {
        "key": case.key,
        "seed": case.seed,
        "hides": case.recipe.hides,
        "parameters": dict(drawn.parameters),
        "claims": [asdict(c) for c in drawn.claims],
    }
    truth_file(folder).write_text(json.dumps(truth, indent=1, default=float) + "\n", "utf-8")
    shutil.rmtree(folder, ignore_errors=True)
    draft.rename(folder)
    return folder


def read(folder: Path) -> dict[Point, np.ndarray]:
    """The stacks of a folder, as they were written."""
    import tifffile

    files: dict[Point, list[str]] = {}
    with (folder / "manifest.csv").open(encoding="utf-8") as stream:
        for row in csv.DictReader(stream):
            point = Point(float(row["temperature_c"]), float(row["exposure_s"]))
            files.setdefault(point, []).append(row["file"])
    return {p: np.stack([tifffile.imread(folder / f) for f in n]) for p, n in files.items()}


def truth(folder: Path) -> dict[str, Any]:
    """What `write` told."""
    return json.loads(truth_file(folder).read_text("utf-8"))
