"""Accumulations to a file and back, as arrays and JSON: what a long run has read so far."""

from __future__ import annotations

import dataclasses
import json
import os
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.analyzers.plan import FrameView, Plan
from dnanalyze.analyzers.streaming.accumulation import Accumulation

_SHARED = ("plan", "_room")  # made anew


def save(path: Path, accumulations: Sequence[Accumulation]) -> None:
    """Write them, whole or not at all.

    Raises
    ------
    OSError
        The folder cannot be written.
    """
    arrays: list[np.ndarray] = []
    plain = [_plain(acc, arrays) for acc in accumulations]
    text = np.frombuffer(json.dumps(plain).encode(), np.uint8)
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez(file, json=text, **{str(k): a for k, a in enumerate(arrays)})  # type: ignore[arg-type]
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def load(path: Path) -> list[Accumulation] | None:
    """What was saved; None where there is nothing, or nothing that can be read."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            plain = json.loads(archive["json"].tobytes())
            arrays = [archive[str(k)] for k in range(len(archive.files) - 1)]
            return [_accumulation(item, arrays) for item in plain]
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile):
        return None


def _plain(acc: Accumulation, arrays: list[np.ndarray]) -> dict[str, Any]:
    acc.wait()
    first = acc.first
    for part in acc.parts.values():
        getattr(part, "flush", lambda: None)()
    state = {
        "plan": dataclasses.asdict(acc.plan),
        "frames": acc.frames,
        "last": acc.last,
        "first": None if first is None else (first.number, first.frame),
        "parts": {
            name: {k: v for k, v in vars(part).items() if k not in _SHARED}
            for name, part in acc.parts.items()
        },
    }
    return _packed(state, arrays)


def _accumulation(plain: dict[str, Any], arrays: list[np.ndarray]) -> Accumulation:
    state = _unpacked(plain, arrays)
    plan = Plan(**state["plan"])
    out = Accumulation(plan)
    out.frames, out.last = state["frames"], state["last"]
    if state["first"] is not None:
        number, frame = state["first"]
        out.first = FrameView(number, frame, None, plan)
    for name, part in out.parts.items():
        vars(part).update(state["parts"][name])
    return out


def _packed(value: Any, arrays: list[np.ndarray]) -> Any:
    """JSON with numbered arrays; tuples stay tuples."""
    if isinstance(value, np.ndarray):
        arrays.append(value)
        return {"array": len(arrays) - 1}
    if isinstance(value, tuple):
        return {"tuple": [_packed(v, arrays) for v in value]}
    if isinstance(value, list):
        return [_packed(v, arrays) for v in value]
    if isinstance(value, dict):
        return {"dict": {k: _packed(v, arrays) for k, v in value.items()}}
    return value.item() if isinstance(value, np.generic) else value


def _unpacked(value: Any, arrays: list[np.ndarray]) -> Any:
    if isinstance(value, list):
        return [_unpacked(v, arrays) for v in value]
    if not isinstance(value, dict):
        return value
    ((kind, content),) = value.items()
    if kind == "array":
        return arrays[content]
    if kind == "tuple":
        return tuple(_unpacked(v, arrays) for v in content)
    return {k: _unpacked(v, arrays) for k, v in content.items()}
