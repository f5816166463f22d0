"""PNG: greyscale of 8 or 16 bit; colour of 8 bit whose channels are all the same."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_length, check_memory, check_shape, check_stored
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.grey import PROCESSED, check_grey
from dnanalyze.loaders.headers import from_header
from dnanalyze.loaders.recording import Metadata, Recording

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_MAX_TEXT = 1 << 16  # bytes of one text chunk
_MAX_CHUNKS = 1_000_000  # encoders write one for 8 kB or more
_CHANNELS = {2: 3, 6: 4}  # colour type to samples a pixel (PNG specification, 11.2.2)


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The chunks of a PNG file; tEXt chunks such as ``temperature_c`` are metadata."""
    size = path.stat().st_size
    texts: dict[str, str] = {}
    with path.open("rb") as file:
        if file.read(8) != _SIGNATURE:
            raise InputError(f"{name}: is no PNG file; correct its suffix")
        kind = header = b""
        stored = chunks = 0
        while kind != b"IEND":
            chunks += 1
            if chunks > _MAX_CHUNKS:
                raise InputError(f"{name}: more than {_MAX_CHUNKS} chunks; damaged: copy it again")
            head = file.read(8)
            if len(head) < 8:
                raise InputError(f"{name}: truncated, no end chunk; copy the file again")
            length, kind = struct.unpack(">I4s", head)
            start = file.tell()
            check_length(name, start + length + 4, size)
            if kind == b"IHDR":
                header = file.read(13)
            elif kind == b"IDAT":
                stored += length
            elif kind == b"tEXt" and length <= _MAX_TEXT:
                key, _, text = file.read(length).decode("latin-1").partition("\0")
                texts[key] = text
            file.seek(start + length + 4)
    if len(header) < 13:
        raise InputError(f"{name}: holds no image header; copy the file again")
    columns, rows, bits, colour = struct.unpack(">IIBB", header[:10])
    channels = _CHANNELS.get(colour, 1)
    if colour not in (0, *_CHANNELS) or bits not in (8, 16) or (channels > 1 and bits == 16):
        raise InputError(
            f"{name}: is no greyscale image of 8 or 16 bit and no colour image of 8 bit; "
            "give raw frames"
        )
    check_shape(name, (rows, columns))
    size = rows * columns * channels * (bits // 8)
    check_memory(name, 4 * size)
    check_stored(name, stored, rows * columns, size)
    dtype = np.dtype(np.uint16 if bits == 16 else np.uint8)
    if channels > 1:
        check_grey(name, _decoded(path))
    notes = (PROCESSED,) if channels > 1 else ()
    metadata: Metadata = from_header(texts)
    return Recording("PNG", (rows, columns), dtype, PngFrame(path), (metadata,), notes=notes)


@dataclass(frozen=True)
class PngFrame:
    """Decodes the image; PNG has no partial reading."""

    path: Path

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window``."""
        array = _decoded(self.path)
        if array.ndim == 3:
            array = array[..., 0]  # the others are the same, as was seen when it was loaded
        return (array if array.dtype.itemsize <= 2 else array.astype(np.uint16))[window.slices]


def _decoded(path: Path) -> np.ndarray:
    from PIL.PngImagePlugin import PngImageFile  # the plugin: our own bound stands for PIL's

    with PngImageFile(path) as image:
        return np.asarray(image)
