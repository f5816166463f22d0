"""Binary PGM (Netpbm P5), 8 or 16 bit; 16-bit values are big-endian."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_shape
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.headers import from_text
from dnanalyze.loaders.layout import ROWS, is_swapped
from dnanalyze.loaders.plain import PlainPixels
from dnanalyze.loaders.recording import Recording

_SPACE = rb"(?:\s|#[^\n]*\n)+"
_HEADER = re.compile(rb"P5" + _SPACE + rb"(\d+)" + _SPACE + rb"(\d+)" + _SPACE + rb"(\d+)\s")


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The header of a PGM file; comments of the form ``# exposure_s = 0.05`` are metadata."""
    with path.open("rb") as file:
        head = file.read(4096)
    match = _HEADER.match(head)
    if match is None:
        raise InputError(f"{name}: is no binary PGM (P5); convert it to P5 or TIFF")
    columns, rows, top = (int(g) for g in match.groups())
    check_shape(name, (rows, columns))
    if not 0 < top < 1 << 16:
        raise InputError(f"{name}: largest value {top} is not within 1 to 65535; damaged header")
    stored = np.dtype(">u2" if top > 255 else "u1")
    plain = PlainPixels(path, (match.end(),), (rows, columns), stored.str)
    plain.check(name)
    if previous is None and top > 255:
        rows_read = min(ROWS, rows)
        words = plain(0, Window(0, rows_read, 0, columns))
        if is_swapped(words):
            raise InputError(
                f"{name}: its 16-bit values are little-endian, and those of PGM are big-endian; "
                "write it anew, or as TIFF"
            )
    comments = re.findall(rb"#\s*([^\n]*)", match[0])
    metadata = from_text(b"\n".join(comments).decode("utf-8", "replace"))
    dtype = stored.newbyteorder("=")
    bits = top.bit_length()
    return Recording("PGM", (rows, columns), dtype, plain, (metadata,), bits=bits)
