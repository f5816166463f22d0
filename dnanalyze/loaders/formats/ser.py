"""SER video (version 3): uncompressed frames of 8 or 16 bit behind a header of 178 bytes."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_count, check_length, check_shape
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.layout import ROWS, is_swapped
from dnanalyze.loaders.plain import PlainPixels
from dnanalyze.loaders.recording import Cfa, Metadata, Recording

HEADER = 178  # bytes
_MAGIC = b"LUCAM-RECORDER"
_MOSAICS: dict[int, Cfa | None] = {
    0: None,
    8: (("R", "G"), ("G", "B")), 9: (("G", "R"), ("B", "G")),
    10: (("G", "B"), ("R", "G")), 11: (("B", "G"), ("G", "R")),
}  # fmt: skip


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The header of a SER file; exposure and temperature stand in a capture program's text."""
    with path.open("rb") as file:
        head = file.read(HEADER)
    if len(head) < HEADER or not head.startswith(_MAGIC):
        raise InputError(f"{name}: is no SER file (no {_MAGIC.decode()}); correct its suffix")
    colour, _, columns, rows, bits, count = struct.unpack("<6i", head[18:42])
    if colour not in _MOSAICS:
        raise InputError(
            f"{name}: ColorID = {colour}, colours or a mosaic that is not read; record RAW or MONO"
        )
    if not 1 <= bits <= 16:
        raise InputError(f"{name}: {bits} bits a pixel; valid: 1 to 16: damaged header")
    check_shape(name, (rows, columns))
    check_count(name, count)
    size = rows * columns * (1 if bits <= 8 else 2)
    check_length(name, HEADER + count * size, path.stat().st_size)
    offsets = range(HEADER, HEADER + count * size, size)
    plain = PlainPixels(path, offsets, (rows, columns), "<u2" if bits > 8 else "u1")
    if bits > 8:
        # The header's LittleEndian is written with both meanings; the codes tell.
        middle = Window(rows // 2 - min(ROWS, rows) // 2, rows // 2, 0, columns)
        if is_swapped(plain(0, middle)):
            plain = PlainPixels(path, offsets, (rows, columns), ">u2")
    return Recording(
        "SER",
        (rows, columns),
        np.dtype(plain.dtype).newbyteorder("="),
        plain,
        (Metadata(),) * count,
        cfa=_MOSAICS[colour],
        bits=bits,
    )
