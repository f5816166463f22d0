"""The text that capture programs write beside a recording: SharpCap, FireCapture, ASICap."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from dnanalyze.loaders.headers import from_header, lines_of
from dnanalyze.loaders.recording import Metadata

_MOST = 1 << 16  # bytes; such texts have a few thousand
_FOR_ALL = "CameraSettings.txt"  # SharpCap, of a sequence of stills


class ProgramTexts:
    """The texts beside the files of a capture.

    Parameters
    ----------
    files : iterable of Path
        All files of the capture.
    """

    def __init__(self, files: Iterable[Path]) -> None:
        self.files = {f for f in files if f.suffix.lower() in (".txt", ".log")}
        self.read: dict[Path, Metadata] = {}

    def of(self, file: Path) -> Metadata:
        """What is said of a file: ``NAME.txt``, ``NAME.CameraSettings.txt``, ``NAME.ser.txt``."""
        stem = file.with_suffix("")
        for text in (
            stem.with_name(f"{stem.name}.txt"), stem.with_name(f"{stem.name}.{_FOR_ALL}"),
            file.with_name(f"{file.name}.txt"), file.with_name(_FOR_ALL),
        ):  # fmt: skip
            if text in self.files:
                if text not in self.read:
                    self.read[text] = _parsed(text)
                return self.read[text]
        return Metadata()


def _parsed(path: Path) -> Metadata:
    try:
        with path.open("rb") as file:
            data = file.read(_MOST)
    except OSError:
        return Metadata()
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")  # Windows programs
    camera = re.match(r"\s*\[(.{1,60})\]", text)  # SharpCap begins with it
    pairs: dict[str, str] = {"INSTRUME": camera[1]} if camera else {}
    for key, value in lines_of(text):
        pairs.setdefault("EXPOSURE" if key.strip().lower() == "shutter" else key, value)
    return from_header(pairs).said_by("text beside it,")
