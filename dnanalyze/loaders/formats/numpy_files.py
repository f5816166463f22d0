"""NumPy ``.npy``: a 2-D frame or a 3-D stack (frame, row, column); never pickles."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, ClassVar

import numpy as np
from numpy.lib import format as npy

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import (
    check_count,
    check_dtype,
    check_length,
    check_shape,
)
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.plain import PlainPixels
from dnanalyze.loaders.recording import Metadata, Recording
from dnanalyze.loaders.stack_order import NOTE, doubtful, frames_last

_MAX_HEADER = 1 << 14  # bytes; a plain array takes 128


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The header of a ``.npy`` file."""
    with path.open("rb") as file:
        shape, fortran, dtype = header(file, name)
        offset = file.tell()
    if doubtful(shape) and dtype.kind in "iuf" and not fortran:
        check_length(name, offset + int(np.prod(shape)) * dtype.itemsize, path.stat().st_size)
        stack = np.memmap(path, dtype, "r", offset, shape)
        if frames_last(name, stack, config.frame_axis):
            frame, count = (shape[0], shape[1]), shape[2]
            check_shape(name, frame)
            check_count(name, count)
            read_last = StackedLast(path, offset, shape, dtype.str)
            return Recording(
                "NumPy", frame, dtype.newbyteorder("="), read_last, (Metadata(),) * count,
                notes=(NOTE,),
            )  # fmt: skip
    count, frame = stack_shape(name, shape, fortran, dtype)
    size = frame[0] * frame[1] * dtype.itemsize
    offsets = range(offset, offset + count * size, size)
    plain = PlainPixels(path, offsets, frame, dtype.str)
    plain.check(name)
    return Recording("NumPy", frame, dtype.newbyteorder("="), plain, (Metadata(),) * count)


@dataclass(frozen=True)
class StackedLast:
    """Frames of an array (rows, columns, frames) in a file."""

    path: Path
    offset: int
    shape: tuple[int, ...]
    dtype: str
    partial: ClassVar[bool] = True

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``."""
        stack = np.memmap(self.path, np.dtype(self.dtype), "r", self.offset, self.shape)
        return np.array(stack[(*window.slices, index)])


def stack_shape(
    name: str, shape: tuple[int, ...], fortran: bool, dtype: np.dtype
) -> tuple[int, tuple[int, int]]:
    """(frames, (rows, columns)) of a 2-D or 3-D array.

    Raises
    ------
    InputError
        Other dimensions, a colour image, Fortran order, no numbers, too many or too large.
    """
    check_dtype(name, dtype)
    if len(shape) not in (2, 3) or 0 in shape:
        raise InputError(
            f"{name}: has shape {str(shape)[:60]}; give (rows, columns) or (frames, rows, columns)"
        )
    if len(shape) == 3 and shape[-1] in (3, 4) and shape[0] > 4:
        raise InputError(f"{name}: has shape {shape}, a colour image; give raw frames")
    if fortran:
        raise InputError(f"{name}: is in Fortran order; save numpy.ascontiguousarray of it")
    rows, columns = shape[-2:]
    check_shape(name, (rows, columns))
    count = shape[0] if len(shape) == 3 else 1
    check_count(name, count)
    return count, (rows, columns)


def header(file: IO[bytes], name: str) -> tuple[tuple[int, ...], bool, np.dtype]:
    """Shape, order and type; leaves the file at the first pixel."""
    version = npy.read_magic(file)
    readers: dict[tuple[int, int], Any] = {
        (1, 0): (npy.read_array_header_1_0, 2),
        (2, 0): (npy.read_array_header_2_0, 4),
    }
    if version not in readers:
        raise InputError(f"{name}: npy version {version} holds no plain numbers; save it again")
    reader, width = readers[version]
    size = file.read(width)  # NumPy would read as many bytes as this says before it judges them
    length = int.from_bytes(size, "little")
    if length > _MAX_HEADER:
        raise InputError(f"{name}: declares a header of {length} bytes; damaged: copy it again")
    shape, fortran, dtype = reader(io.BytesIO(size + file.read(length)))
    if dtype.hasobject:
        raise InputError(f"{name}: holds Python objects, which are never loaded; save numbers")
    if any(type(n) is not int or n < 0 for n in shape):
        raise InputError(f"{name}: declares the shape {str(shape)[:60]}; its header is damaged")
    return shape, fortran, dtype
