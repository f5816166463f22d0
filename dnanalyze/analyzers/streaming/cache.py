"""Statistics kept on disk, so that a second command does not read the frames again.

An entry is one NumPy archive: the curves as arrays, all else as JSON. Its name is a digest of what
the statistics depend on: the files (path, size, time, first and last bytes), how they are read,
the part of the frame, and the code of the analyzers.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics, Value
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint

ENDS = 1 << 16  # bytes at either end of a file that go into the digest
LIMIT = 1 << 30  # bytes; the entries that were not used for longest are removed first
SUFFIX = ".npz"
Made = TypeVar("Made")


def default_folder() -> Path | None:
    """Where entries are kept: ``DNANALYZE_CACHE``, else the user's cache folder.

    None where the variable is "off".
    """
    named = os.environ.get("DNANALYZE_CACHE")
    if named is not None:
        return None if named in ("", "0", "off") else Path(named)
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or str(Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = str(Path.home() / "Library" / "Caches")
    else:
        base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "dnanalyze"


def held(captures: CaptureSet, *asked: object) -> Entry | None:
    """The entry of what is ``asked`` of these captures; None where none can be kept.

    Their source must name a folder, outside the captures', and every frame come from a file.
    """
    folder = captures.source.cache if captures.source else None
    if folder is None:
        return None
    try:
        files = {path: _content(path) for path in sorted(set(_files(captures)))}
        if not files or any(Path(folder).resolve().is_relative_to(p.parent) for p in files):
            return None
        digest = hashlib.blake2b(digest_size=20)
        settings = [
            (s.point, [(f.name, repr(f.load)) for f in s.frames]) for s in captures.settings
        ]
        for part in (code(*READERS), captures.sensor, settings, files, asked):
            digest.update(repr(part).encode())
            digest.update(b"\0")
    except (OSError, _NoFile):
        return None
    return Entry(Path(folder) / (digest.hexdigest() + SUFFIX))


class _NoFile(Exception):
    """A frame that comes from no file."""


def _files(captures: CaptureSet) -> Iterator[Path]:
    for frame in captures.frames():
        files = [p.resolve() for p in _paths(frame.load)]
        if not files:
            raise _NoFile
        yield from files


def _paths(reader: Any) -> Iterator[Path]:
    """Every path in a tree of dataclasses, as readers of files are."""
    if isinstance(reader, Path):
        yield reader
    elif dataclasses.is_dataclass(reader):
        for item in dataclasses.fields(reader):
            yield from _paths(getattr(reader, item.name))


def _content(path: Path) -> tuple[int, int, str]:
    """Size, time of change in ns, and digest of the ends."""
    state = path.stat()
    with path.open("rb") as file:
        ends = file.read(ENDS)
        if state.st_size > ENDS:
            file.seek(max(ENDS, state.st_size - ENDS))
            ends += file.read(ENDS)
    return state.st_size, state.st_mtime_ns, hashlib.blake2b(ends, digest_size=16).hexdigest()


PACKAGE = Path(__file__).parents[2]
READERS = (PACKAGE / "analyzers", PACKAGE / "loaders")


@cache
def code(*folders: Path) -> str:
    """Digest of all modules under folders: what another version makes has entries of its own."""
    digest = hashlib.blake2b(digest_size=16)
    for folder in folders:
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()


@dataclasses.dataclass(frozen=True)
class Entry:
    """One file of the cache."""

    path: Path

    def get(self, captures: CaptureSet) -> list[Statistics] | None:
        """What was put; None where there is nothing, or nothing that can be read."""
        return self.read(lambda plain, archive: [_statistics(i, archive, captures) for i in plain])

    def read(self, build: Callable[[Any, Mapping[str, np.ndarray]], Made]) -> Made | None:
        """What ``build`` makes of the JSON and the arrays; None where it cannot."""
        try:
            with self.path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
                made = build(json.loads(archive["json"].tobytes()), archive)
            os.utime(self.path)
        except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile):
            return None
        return made

    def put(self, statistics: Sequence[Statistics]) -> None:
        """Keep them; a folder that cannot be written keeps nothing."""
        curves: dict[str, np.ndarray] = {}
        plain = [_plain(item, str(k), curves) for k, item in enumerate(statistics)]
        self.write(plain, curves)

    def write(self, plain: Any, curves: Mapping[str, np.ndarray]) -> None:
        """Keep what JSON holds, and arrays."""
        text = np.frombuffer(json.dumps(plain).encode(), np.uint8)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            handle, temporary = tempfile.mkstemp(dir=self.path.parent, suffix=".part")
            try:
                with os.fdopen(handle, "wb") as file:
                    np.savez(file, json=text, **curves)  # type: ignore[arg-type]
                os.replace(temporary, self.path)
            except BaseException:
                os.unlink(temporary)
                raise
            _prune(self.path.parent)
        except OSError:
            return


def _prune(folder: Path) -> None:
    entries = sorted((p.stat().st_mtime, p.stat().st_size, p) for p in folder.glob("*" + SUFFIX))
    total = sum(size for _, size, _ in entries)
    for _, size, path in entries[:-1]:
        if total <= LIMIT:
            break
        path.unlink(missing_ok=True)
        total -= size


def _plain(item: Statistics, key: str, curves: dict[str, np.ndarray]) -> dict[str, Any]:
    settings = []
    for k, setting in enumerate(item.settings):
        names = list(setting.curves)
        curves |= {
            f"{key}/{k}/{n}": np.asarray(setting.curves[name]) for n, name in enumerate(names)
        }
        settings.append(
            {
                "point": dataclasses.asdict(setting.point),
                "plane": setting.plane,
                "frames": setting.frames,
                "shape": setting.shape,
                "values": _numbers(setting.values),
                "curves": names,
                "missing": setting.missing,
            }
        )
    return {"key": key, "settings": settings, "trends": _numbers(item.trends)}


def _numbers(values: dict[str, Value]) -> dict[str, tuple[float, float]]:
    return {name: (float(v.value), float(v.se)) for name, v in values.items()}


def _statistics(plain: dict[str, Any], archive: Any, captures: CaptureSet) -> Statistics:
    settings = tuple(
        SettingStatistics(
            OperatingPoint(**s["point"]),
            s["plane"],
            s["frames"],
            (s["shape"][0], s["shape"][1]),
            {n: Value(*v) for n, v in s["values"].items()},
            {name: archive[f"{plain['key']}/{k}/{n}"] for n, name in enumerate(s["curves"])},
            s["missing"],
        )
        for k, s in enumerate(plain["settings"])
    )
    trends = {n: Value(*v) for n, v in plain["trends"].items()}
    return Statistics(captures.name, captures.sensor, settings, trends)
