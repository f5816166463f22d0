"""The text header of ENVI files: ``frame.hdr`` (or ``frame.raw.hdr``) beside ``frame.raw``."""

from __future__ import annotations

import os
import re
from pathlib import Path

from dnanalyze.errors import InputError
from dnanalyze.loaders.text import read_text

SUFFIXES = (".raw", ".img", ".dat", ".bin", ".bsq", ".bil", ".bip")
_MAX_BYTES = 1 << 20  # wavelengths and names of a thousand bands take 50 kB
_FIELD = re.compile(r"^[ \t]*([^=\n{}]{1,60}?)[ \t]*=[ \t]*(\{[^}]*\}|[^\n]*)", re.MULTILINE)


def header_beside(path: Path) -> Path | None:
    """The ENVI header that describes a file of pixels; None where there is none."""
    if path.suffix.lower() not in SUFFIXES:
        return None
    for header in (path.with_suffix(".hdr"), path.with_suffix(".HDR"), Path(f"{path}.hdr")):
        if os.path.isfile(header) and _is_envi(header):
            return header
    return None


def fields_of(path: Path) -> dict[str, str]:
    """The fields of a header by name, in lower case; a later one of a name is left out.

    Raises
    ------
    InputError
        Unreadable, too large, no text.
    """
    header: dict[str, str] = {}
    for name, value in _FIELD.findall(read_text(path, _MAX_BYTES)):
        header.setdefault(" ".join(name.lower().split()), value.strip())
    return header


def whole(fields: dict[str, str], name: str, default: int | None, where: str) -> int:
    """A field that is a whole number of 0 or more.

    Raises
    ------
    InputError
        Absent without a default, or something else.
    """
    text = fields.get(name, "" if default is None else str(default))
    if not re.fullmatch(r"\d{1,18}", text):
        said = f"{name} = {text[:40]!r}" if name in fields else f"no field {name!r}"
        raise InputError(f"{where}: {said}; valid: a whole number")
    return int(text)


def _is_envi(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(16).lstrip(b"\xef\xbb\xbf").split(b"\n")[0].strip() == b"ENVI"
    except OSError:
        return False
