"""ENVI: pixels without a header of their own, described by the text file beside them.

The bands are frames, whatever their interleave: by band (bsq), by line (bil) or by pixel (bip).
Data types and byte order as in the ENVI header format (NV5 Geospatial, "ENVI Header Files").
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_count, check_length, check_shape
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.formats.envi_header import fields_of, header_beside, whole
from dnanalyze.loaders.headers import from_header
from dnanalyze.loaders.layout import ROWS, is_swapped
from dnanalyze.loaders.plain import PlainPixels
from dnanalyze.loaders.recording import Recording

_DTYPES = {
    1: "u1", 2: "i2", 3: "i4", 4: "f4", 5: "f8", 12: "u2", 13: "u4", 14: "i8", 15: "u8",
}  # fmt: skip
_INTERLEAVES = ("bsq", "bil", "bip")


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """What the header beside the file says."""
    header = header_beside(path)
    if header is None:
        raise InputError(f"{name}: no ENVI header beside it; it was removed: copy it again")
    where = f"{name}: {header.name}"
    fields = fields_of(header)
    shape = whole(fields, "lines", None, where), whole(fields, "samples", None, where)
    check_shape(name, shape)
    count = whole(fields, "bands", 1, where)
    check_count(name, count)
    kind = whole(fields, "data type", None, where)
    order = whole(fields, "byte order", 0, where)
    interleave = fields.get("interleave", "bsq").lower()
    for field, value, valid in (
        ("data type", kind, tuple(_DTYPES)),
        ("byte order", order, (0, 1)),
        ("interleave", interleave, _INTERLEAVES),
        ("file compression", whole(fields, "file compression", 0, where), (0,)),
    ):
        if value not in valid:
            raise InputError(
                f"{where}: {field} = {str(value)[:40]}; valid: {', '.join(map(str, valid))}"
            )
    dtype = np.dtype(("<" if order == 0 else ">") + _DTYPES[kind])
    offset, frame = whole(fields, "header offset", 0, where), shape[0] * shape[1] * dtype.itemsize
    check_length(name, offset + count * frame, path.stat().st_size)
    decode: PlainPixels | Interleaved
    if interleave == "bsq" or count == 1:
        decode = PlainPixels(path, range(offset, offset + count * frame, frame), shape, dtype.str)
    else:
        decode = Interleaved(path, offset, shape, count, dtype.str, interleave == "bil")
    if previous is None and dtype.kind in "iu" and dtype.itemsize == 2:
        words = decode(0, Window(0, min(ROWS, shape[0]), 0, shape[1]))
        if is_swapped(words.view(np.uint16)):
            raise InputError(
                f"{where}: byte order = {order}, and the codes are smooth in the other alone; set "
                f"byte order = {1 - order}"
            )
    metadata = from_header(fields)
    return Recording("ENVI", shape, dtype.newbyteorder("="), decode, (metadata,) * count)


@dataclass(frozen=True)
class Interleaved:
    """Frames woven into one another, line by line or pixel by pixel.

    Parameters
    ----------
    path : Path
    offset : int
        First byte of the first pixel.
    shape : tuple of int
        (rows, columns) of a frame.
    count : int
        Frames.
    dtype : str
        With byte order.
    by_line : bool
        Line by line, or else pixel by pixel.
    """

    path: Path
    offset: int
    shape: tuple[int, int]
    count: int
    dtype: str
    by_line: bool

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``, native byte order."""
        rows, columns = self.shape
        woven = (rows, self.count, columns) if self.by_line else (rows, columns, self.count)
        mapped = np.memmap(self.path, np.dtype(self.dtype), "r", self.offset, woven)
        frame = mapped[:, index] if self.by_line else mapped[..., index]
        part = np.array(frame[window.slices])
        return part.astype(part.dtype.newbyteorder("="), copy=False)
