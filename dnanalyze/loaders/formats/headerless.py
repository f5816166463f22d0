"""Headerless raw: 8 to 16 bit, plain or packed, as the sidecar describes it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_count, check_length, check_shape
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.packing import PACKED_BITS, group_of, row_bytes, unpack
from dnanalyze.loaders.plain import PlainPixels
from dnanalyze.loaders.recording import Metadata, Recording

_BITS = (8, 10, 12, 14, 16)


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """What the sidecar and the file's size say; a file may hold several frames in a row."""
    width, height, bits = config.width, config.height, config.bits
    if width is None or height is None or bits is None:
        raise InputError(
            f"{name}: headerless; describe it in dnanalyze.yaml beside it or with --config: "
            "width, height, bits, and where needed packing, byte_order, header_offset"
        )
    check_shape(name, (height, width))
    if bits not in _BITS:
        raise InputError(f"{name}: bits {bits} in the sidecar; valid: {', '.join(map(str, _BITS))}")
    packed = config.packing != "plain" and bits in PACKED_BITS
    stride = config.row_bytes or row_bytes(width, bits, config.packing)
    if stride < row_bytes(width, bits, config.packing):
        raise InputError(f"{name}: row_bytes {stride} in the sidecar is too few for {width} pixels")
    order = "<" if config.byte_order == "little" else ">"
    dtype = np.dtype("u1" if bits == 8 else f"{order}u2")
    present, frame = path.stat().st_size - config.header_offset, height * stride
    check_length(name, config.header_offset + frame, present + config.header_offset)
    count, rest = divmod(present, frame)
    if rest:
        raise InputError(
            f"{name}: {present} bytes of pixels are not a multiple of the {frame} of a frame of "
            f"{width} x {height} with {bits} bits; correct width, height, bits, packing or "
            "header_offset in the sidecar"
        )
    check_count(name, count)
    offsets = range(config.header_offset, config.header_offset + count * frame, frame)
    decode: PlainPixels | RawRows
    if not packed and stride == width * dtype.itemsize:
        decode = PlainPixels(path, offsets, (height, width), dtype.str)
    else:
        packing = config.packing if packed else "plain"
        decode = RawRows(path, offsets, width, stride, bits, packing, dtype.str)
    kind = f"RAW{bits} {config.packing}" if packed else f"RAW{bits}"
    native = np.dtype(np.uint16) if packed else dtype.newbyteorder("=")
    return Recording(kind, (height, width), native, decode, (Metadata(),) * count, bits=bits)


@dataclass(frozen=True)
class RawRows:
    """Packed or padded rows; only the rows and groups that a window touches are unpacked."""

    path: Path
    offsets: Sequence[int]
    width: int
    stride: int
    bits: int
    packing: str
    dtype: str
    partial: ClassVar[bool] = True

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``."""
        rows = window.shape[0]
        start = self.offsets[index] + window.top * self.stride
        data = np.fromfile(self.path, np.uint8, rows * self.stride, offset=start)
        check_length(self.path.name, rows * self.stride, data.size)
        data = data.reshape(rows, self.stride)
        if self.packing == "plain":
            used = np.ascontiguousarray(data[:, : self.width * np.dtype(self.dtype).itemsize])
            return used.view(self.dtype)[:, window.left : window.right]
        pixels, size = group_of(self.bits)
        first, last = window.left // pixels, -(-window.right // pixels)
        part = unpack(
            data[:, first * size : last * size], (last - first) * pixels, self.bits, self.packing
        )
        return part[:, window.left - first * pixels : window.right - first * pixels]
