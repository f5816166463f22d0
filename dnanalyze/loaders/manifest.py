"""``manifest.csv`` or ``manifest.yaml``: the user's own table, which outranks all else."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from dnanalyze.errors import InputError
from dnanalyze.loaders.files import MANIFESTS, MAX_FILES, Place, inside
from dnanalyze.loaders.physical import fault
from dnanalyze.loaders.recording import Metadata
from dnanalyze.loaders.text import read_text, read_yaml

COLUMNS = ("file", "temperature_c", "exposure_s", "gain", "channel", "frame")
MAX_GLOBBED = 10_000_000  # names held against globs; about 10 s


def read_manifest(place: Place) -> dict[Path, Metadata] | None:
    """Metadata of each file that the manifest names; None without a manifest.

    A later row fills only what an earlier row of the same file leaves empty. Several rows of one
    file that differ in ``frame`` are not supported: a file's frames share its metadata.

    Raises
    ------
    InputError
        A file that is not there or leaves the folder, an unknown column, a value that is no
        number; the message names manifest, row and remedy.
    """
    path = next((place.root / m for m in MANIFESTS if os.path.lexists(place.root / m)), None)
    if path is None:
        return None
    rows = _csv_rows(path) if path.suffix == ".csv" else _yaml_rows(path)
    known = {place.relative(f): f for f in place.files}
    by_file: dict[Path, Metadata] = {}
    count = globbed = 0
    for number, row in rows:
        count += 1
        if count > MAX_FILES:
            raise InputError(f"{path}: more than {MAX_FILES} rows; name files by a glob")
        where = f"{path}: row {number}"
        metadata = _metadata(row, where).of(path.name)
        pattern = str(row.get("file") or "").strip()
        globbed += len(known) * any(c in pattern for c in "*?[")
        if globbed > MAX_GLOBBED:
            raise InputError(f"{where}: too many globs for {len(known)} files; name files or fewer")
        for file in _matches(place, known, pattern, where):
            by_file[file] = by_file[file].or_else(metadata) if file in by_file else metadata
    if not count:
        raise InputError(f"{path}: has no rows; name the frames, or remove the manifest")
    return by_file


def _matches(place: Place, known: dict[str, Path], pattern: str, where: str) -> list[Path]:
    if not pattern:
        raise InputError(f"{where}: no file named; the column 'file' holds a name or a glob")
    pattern = pattern.replace("\\", "/").removeprefix("./")
    shown = pattern if len(pattern) <= 80 else pattern[:77] + "..."
    if pattern in known:
        return [known[pattern]]
    if pattern.startswith("/") or ".." in pattern.split("/"):
        raise InputError(f"{where}: {shown} leads outside the folder; name files below it")
    path = place.root / pattern
    if os.path.exists(path):  # unlike Path.exists, False for a name that no system can have
        inside(place.root, path, where)
        if path.is_dir():
            raise InputError(f"{where}: {shown} is a folder; write {shown.rstrip('/')}/*")
        return []  # one file was asked for, and this is another
    matched = [file for name, file in known.items() if fnmatchcase(name, pattern)]
    if not matched and not (place.single and any(c in pattern for c in "*?[")):
        raise InputError(f"{where}: {shown} is not in the folder; correct the name or the row")
    return matched


def _metadata(row: dict[str, Any], where: str) -> Metadata:
    def number(column: str) -> float | None:
        value = row.get(column)
        if value is None or str(value).strip() == "":
            return None
        try:
            result: Any = float(value)
        except (TypeError, ValueError, OverflowError):
            result = str(value)
        if wrong := fault(column, result):
            raise InputError(f"{where}: {wrong}")
        return result

    channel = str(row.get("channel") or "").strip() or None
    return Metadata(
        number("temperature_c"), number("exposure_s"), number("gain"), channel, number("frame")
    )


def _csv_rows(path: Path) -> Iterable[tuple[int, dict[str, Any]]]:
    lines = read_text(path).splitlines()
    if not lines:
        raise InputError(f"{path}: is empty; valid columns: {', '.join(COLUMNS)}")
    dialect = ";" if lines[0].count(";") > lines[0].count(",") else ","
    try:
        reader = csv.DictReader(lines, delimiter=dialect, skipinitialspace=True, strict=True)
        _check_columns(path, [c.strip() for c in reader.fieldnames or []])
        reader.fieldnames = [c.strip() for c in reader.fieldnames or []]
        for row in reader:
            if None in row:
                raise InputError(f"{path}: row {reader.line_num}: more values than columns")
            if any((v or "").strip() for v in row.values()):
                yield reader.line_num, row
    except csv.Error as error:
        raise InputError(f"{path}: is no CSV table: {error}") from error


def _yaml_rows(path: Path) -> Iterable[tuple[int, dict[str, Any]]]:
    table = read_yaml(path)
    if isinstance(table, dict) and set(table) == {"frames"}:
        table = table["frames"]
    if not isinstance(table, list) or not all(isinstance(r, dict) for r in table):
        raise InputError(f"{path}: must be a list of rows such as '- file: a.tif'")
    for number, row in enumerate(table, 1):
        _check_columns(path, list(row))
        yield number, row


def _check_columns(path: Path, columns: list[Any]) -> None:
    unknown = [str(c) for c in columns if c not in COLUMNS]
    if unknown:
        raise InputError(
            f"{path}: unknown column {unknown[0]!r}; valid columns: {', '.join(COLUMNS)}"
        )
    twice = [c for c in columns if columns.count(c) > 1]
    if twice:
        raise InputError(f"{path}: column {twice[0]!r} occurs twice; keep one of them")
    if "file" not in columns:
        raise InputError(f"{path}: no column 'file'; valid columns: {', '.join(COLUMNS)}")
