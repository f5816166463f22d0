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
from dnanalyze.loaders.layout import (
    GROUPS,
    ROWS,
    bytes_fault,
    is_turned,
    odd_edges,
    packing_fault,
    side_of,
    words_fault,
)
from dnanalyze.loaders.packing import PACKINGS, group_of, row_bytes, unpack
from dnanalyze.loaders.plain import PlainPixels
from dnanalyze.loaders.recording import Metadata, Recording

_BITS = (8, 10, 12, 14, 16)


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """What the sidecar and the file's size say; a file may hold several frames in a row."""
    width, height, bits = config.width, config.height, config.bits
    if width is None or height is None or bits is None:
        raise InputError(
            f"{name}: headerless; describe it in dnanalyze.yaml in its folder, or with --sidecar: "
            "width, height, bits, and where needed packing, byte_order, header_offset"
        )
    check_shape(name, (height, width))
    if bits not in _BITS:
        raise InputError(f"{name}: bits {bits} in the sidecar; valid: {', '.join(map(str, _BITS))}")
    packed = bits in PACKINGS.get(config.packing, ())
    if config.packing == "genicam" and bits == 14:
        raise InputError(f"{name}: packing genicam in the sidecar has 10 or 12 bits; give bits")
    stride = config.row_bytes or row_bytes(width, bits, config.packing)
    if stride < row_bytes(width, bits, config.packing):
        raise InputError(f"{name}: row_bytes {stride} in the sidecar is too few for {width} pixels")
    order = "<" if config.byte_order == "little" else ">"
    dtype = np.dtype("u1" if bits == 8 else f"{order}u2")
    around = config.header_offset + config.footer_bytes
    present, frame = path.stat().st_size - around, height * stride
    check_length(name, around + frame, present + around)
    count, rest = divmod(present, frame)
    if rest:
        raise InputError(
            f"{name}: {present} bytes of pixels are not a multiple of the {frame} of a frame of "
            f"{width} x {height} with {bits} bits; correct width, height, bits or packing in the "
            f"sidecar{_fitting(present, config)}, or set {_beside(path, rest, config)}"
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
    notes: tuple[str, ...] = ()
    if previous is None:
        raw = RawRows(path, offsets, stride, stride, 8, "plain", "u1")
        if fault := _fault(raw, (height, width), config, packed, dtype):
            raise InputError(f"{name}: {fault} in the sidecar")
        if isinstance(decode, PlainPixels) and is_turned(decode(0, Window(0, height, 0, width))):
            raise InputError(
                f"{name}: columns of {height} rows make no pattern, those of {width} do: height "
                f"and width are exchanged; set width: {height} and height: {width} in the sidecar"
            )
        note = odd_edges(lambda a, b: decode(0, Window(a, b, 0, width)), height)
        notes = (note,) if note else ()
    return Recording(
        kind, (height, width), native, decode, (Metadata(),) * count, bits=bits, notes=notes
    )


def _fault(
    raw: RawRows, shape: tuple[int, int], config: Config, packed: bool, dtype: np.dtype
) -> str:
    """What the rows in the middle of the first frame show to be wrong with the layout."""
    height, width = shape
    count = max(2, min(ROWS, height, (1 << 20) // raw.stride))
    first = (height - count) // 2
    rows = raw(0, Window(first, first + count, 0, raw.stride))
    bits, lead = config.bits or 16, -(first * raw.stride) % GROUPS
    if packed:
        return packing_fault(rows, width, bits, config.packing, lead)
    used = np.ascontiguousarray(rows[:, : width * dtype.itemsize])
    if dtype.itemsize == 1:
        return bytes_fault(used, lead)
    words = used.view(dtype).astype(np.uint16)
    return words_fault(words, bits, config.byte_order, lead)


def _fitting(present: int, config: Config) -> str:
    """The packings in which the bytes are whole frames."""
    width, height, bits = config.width or 1, config.height or 1, config.bits or 16
    known = [how for how, depths in PACKINGS.items() if bits in depths]
    fitting = [h for h in ("plain", *known) if present % (height * row_bytes(width, bits, h)) == 0]
    return f" (packing {' or '.join(fitting)} would fit)" if fitting else ""


def _beside(path: Path, rest: int, config: Config) -> str:
    """The key that accounts for bytes too many: those before or behind the pixels."""
    end = min(rest, 1 << 16)
    size = 1 << 18
    with path.open("rb") as file:
        file.seek(config.header_offset)
        data = file.read(end + size)
        file.seek(-(end + config.footer_bytes), 2)
        data += file.read(end)
    header = f"header_offset: {config.header_offset + rest}"
    footer = f"footer_bytes: {config.footer_bytes + rest}"
    side = side_of(data, end)
    if not side:
        return f"{header} or {footer}, whichever end holds no pixels"
    return header if side == "header" else footer


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
        pixels, size = group_of(self.bits, self.packing)
        first, last = window.left // pixels, -(-window.right // pixels)
        held = data[:, first * size : last * size]
        if short := (last - first) * size - held.shape[1]:  # rows that end within a group
            held = np.pad(held, ((0, 0), (0, short)))
        part = unpack(held, (last - first) * pixels, self.bits, self.packing)
        return part[:, window.left - first * pixels : window.right - first * pixels]
