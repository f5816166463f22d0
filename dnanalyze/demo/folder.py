"""Write a capture set as a folder: one TIFF a frame, a manifest, and what was hidden beside it."""

from __future__ import annotations

import csv
import json
import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet

COLUMNS = ("file", "temperature_c", "exposure_s", "gain", "channel")


def write_folder(captures: CaptureSet, path: Path, truth: Mapping[str, Any] | None = None) -> Path:
    """Write frames as ``T+025C/dark_000.tif`` with ``manifest.csv``; all of it or nothing.

    Parameters
    ----------
    captures : CaptureSet
        Integer frames whose names are relative file names.
    path : Path
        Folder to make; it must not exist.
    truth : mapping, optional
        Written beside the folder as ``<name>.truth.json``, where a diagnosis does not look.

    Raises
    ------
    InputError
        The folder exists.
    """
    import tifffile

    path = Path(path)
    if path.exists():
        raise InputError(f"{path}: exists already; name a new folder")
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = Path(tempfile.mkdtemp(prefix=f".{path.name}-", dir=path.parent))
    try:
        with (draft / "manifest.csv").open("w", newline="", encoding="utf-8") as stream:
            table = csv.writer(stream)
            table.writerow(COLUMNS)
            for frame in captures.frames():
                file = draft / frame.name
                file.parent.mkdir(parents=True, exist_ok=True)
                tifffile.imwrite(file, frame.read())
                p = frame.point
                table.writerow([frame.name, p.temperature_c, p.exposure_s, p.gain, p.channel])
        draft.chmod(0o755)  # mkdtemp makes it private
        os.rename(draft, path)
    except BaseException:
        shutil.rmtree(draft, ignore_errors=True)
        raise
    if truth is not None:
        beside = path.with_name(f"{path.name}.truth.json")
        beside.write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8")
    return path
