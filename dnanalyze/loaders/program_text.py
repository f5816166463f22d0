"""The text that capture programs write beside a recording.

SharpCap, FireCapture and ASICap write lines of text, picamera2 and Micro-Manager JSON.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from dnanalyze.loaders.headers import from_header, lines_of
from dnanalyze.loaders.recording import Metadata

_MOST = 1 << 16  # bytes; such texts have a few thousand
_MOST_JSON = 16 << 20  # Micro-Manager writes about 4 kB a frame
_NAMES = {"shutter": "EXPOSURE", "black level": "BLKLEVEL"}  # of FireCapture and SharpCap
_FOR_ALL = "CameraSettings.txt"  # SharpCap, of a sequence of stills


class ProgramTexts:
    """The texts beside the files of a capture.

    Parameters
    ----------
    files : iterable of Path
        All files of the capture.
    """

    def __init__(self, files: Iterable[Path]) -> None:
        self.files = {f for f in files if f.suffix.lower() in (".txt", ".json")}
        self.read: dict[Path, Metadata] = {}
        self.tables: dict[Path, dict[str, Metadata]] = {}

    def of(self, file: Path) -> Metadata:
        """What is said of a file.

        ``NAME.txt``, ``NAME.json``, ``NAME.CameraSettings.txt`` or ``NAME.ser.txt`` says it, or
        ``CameraSettings.txt`` or Micro-Manager's ``metadata.txt`` of the folder.
        """
        if not self.files:
            return Metadata()
        table = file.with_name("metadata.txt")
        if table in self.files:
            if table not in self.tables:
                self.tables[table] = _by_name(table)
            if file.name in self.tables[table]:
                return self.tables[table][file.name]
        beside = (f"{file.stem}.txt", f"{file.stem}.json", f"{file.stem}.{_FOR_ALL}")
        for text in map(file.with_name, (*beside, f"{file.name}.txt", _FOR_ALL)):
            if text in self.files:
                if text not in self.read:
                    self.read[text] = _parsed(text)
                return self.read[text]
        return Metadata()


def _parsed(path: Path) -> Metadata:
    text = _text(path, _MOST)
    if (plain := _json(text)) is not None:
        # libcamera counts the exposure in us, and knows the time of a frame
        if "FrameDuration" in plain and "ExposureTime" in plain:
            plain = {**plain, "ExposureTime": f"{plain['ExposureTime']} us"}
        return _said(plain)
    camera = re.match(r"\s*\[(.{1,60})\]", text)  # SharpCap begins with it
    pairs: dict[str, str] = {"INSTRUME": camera[1]} if camera else {}
    for key, value in lines_of(text):
        pairs.setdefault(_NAMES.get(key.strip().lower(), key), value)
    return _said(pairs)


def _by_name(path: Path) -> dict[str, Metadata]:
    """Micro-Manager's table of the files of a folder."""
    plain = _json(_text(path, _MOST_JSON)) or {}
    frames = [flat_properties(v) for v in plain.values() if isinstance(v, dict)]
    return {
        Path(str(f["FileName"]).replace("\\", "/")).name: _said(f)
        for f in frames
        if "FileName" in f
    }


def flat_properties(plain: Mapping[str, Any]) -> dict[str, Any]:
    """The properties of one frame of Micro-Manager, without the name of an only channel."""
    flat = {k: v.get("PropVal") if isinstance(v, dict) else v for k, v in plain.items()}
    if str(flat.get("Channel", "")).strip() in ("", "Default"):
        flat.pop("Channel", None)
    return flat


def _said(pairs: Mapping[str, Any]) -> Metadata:
    return from_header(pairs).said_by("text beside it,")


def _json(text: str) -> dict[str, Any] | None:
    if not text.lstrip().startswith("{"):
        return None
    try:
        plain = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return plain if isinstance(plain, dict) else None


def _text(path: Path, most: int) -> str:
    """The content of a small text file; "" where it cannot be read or is larger."""
    try:
        with path.open("rb") as file:
            data = file.read(most + 1)
    except OSError:
        return ""
    if len(data) > most:
        return ""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace")  # Windows programs
