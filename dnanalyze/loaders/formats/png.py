"""PNG, greyscale, 8 or 16 bit."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_length, check_memory, check_shape
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.headers import from_header
from dnanalyze.loaders.recording import Metadata, Recording

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_MAX_TEXT = 1 << 16  # bytes of one text chunk


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The chunks of a PNG file; tEXt chunks such as ``temperature_c`` are metadata."""
    size = path.stat().st_size
    texts: dict[str, str] = {}
    with path.open("rb") as file:
        if file.read(8) != _SIGNATURE:
            raise InputError(f"{name}: is no PNG file; correct its suffix")
        kind = b""
        header = b""
        while kind != b"IEND":
            head = file.read(8)
            if len(head) < 8:
                raise InputError(f"{name}: truncated, no end chunk; copy the file again")
            length, kind = struct.unpack(">I4s", head)
            start = file.tell()
            check_length(name, start + length + 4, size)
            if kind == b"IHDR":
                header = file.read(13)
            elif kind == b"tEXt" and length <= _MAX_TEXT:
                key, _, text = file.read(length).decode("latin-1").partition("\0")
                texts[key] = text
            file.seek(start + length + 4)
    columns, rows, bits, colour = struct.unpack(">IIBB", header[:10])
    if colour != 0 or bits not in (8, 16):
        raise InputError(f"{name}: is no greyscale image of 8 or 16 bit; give raw frames")
    check_shape(name, (rows, columns))
    check_memory(name, 4 * rows * columns * (bits // 8))
    dtype = np.dtype(np.uint16 if bits == 16 else np.uint8)
    metadata: Metadata = from_header(texts)
    return Recording("PNG", (rows, columns), dtype, PngFrame(path), (metadata,))


@dataclass(frozen=True)
class PngFrame:
    """Decodes the image; PNG has no partial reading."""

    path: Path

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window``."""
        from PIL.PngImagePlugin import PngImageFile  # the plugin: our own bound stands for PIL's

        with PngImageFile(self.path) as image:
            array = np.asarray(image)
        return (array if array.dtype.itemsize <= 2 else array.astype(np.uint16))[window.slices]
