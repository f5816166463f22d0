"""NumPy ``.npy`` and ``.npz``: 2-D frames or 3-D stacks (frame, row, column); never pickles."""

from __future__ import annotations

import io
import zipfile
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
    check_memory,
    check_shape,
    check_stored,
)
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.headers import from_header
from dnanalyze.loaders.plain import PlainPixels
from dnanalyze.loaders.recording import Metadata, Recording
from dnanalyze.loaders.stack_order import NOTE, doubtful, frames_last

_MAX_HEADER = 1 << 14  # bytes; a plain array takes 128


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The header of a ``.npy`` or ``.npz`` file."""
    if path.suffix.lower() == ".npz":
        return _read_npz(path, name)
    with path.open("rb") as file:
        shape, fortran, dtype = _header(file, name)
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


@dataclass(frozen=True)
class NpzFrames:
    """Frames of the arrays of an ``.npz``: (member, index in it) for each."""

    path: Path
    places: tuple[tuple[str, int], ...]

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``; the member is read up to that frame only."""
        member, number = self.places[index]
        with zipfile.ZipFile(self.path) as archive, archive.open(member) as file:
            shape, _, dtype = _header(file, member)
            pixels = shape[-2] * shape[-1]
            file.seek(number * pixels * dtype.itemsize, 1)
            data = file.read(pixels * dtype.itemsize)
            return np.frombuffer(data, dtype, pixels).reshape(shape[-2:])[window.slices]


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


def _read_npz(path: Path, name: str) -> Recording:
    places: list[tuple[str, int]] = []
    first: tuple[tuple[int, int], np.dtype] | None = None
    metadata = Metadata()
    with zipfile.ZipFile(path) as archive:
        check_count(name, len(archive.infolist()))
        for info in archive.infolist():
            label = f"{name}: {info.filename}"
            with archive.open(info) as file:
                shape, fortran, dtype = _header(file, label)
                start = file.tell()
                if len(shape) < 2:
                    metadata = metadata.or_else(_scalar(file, info, shape, dtype))
                    continue
            count, frame = stack_shape(label, shape, fortran, dtype)
            size = frame[0] * frame[1] * dtype.itemsize
            if info.file_size < start + count * size:
                raise InputError(f"{label}: truncated; write the file again")
            check_memory(label, 2 * size)
            pixels = count * frame[0] * frame[1]
            check_stored(label, info.compress_size, pixels, count * size)
            if first is not None and (frame, dtype) != first:
                raise InputError(
                    f"{label}: is {frame} {dtype}, the first array {first[0]} {first[1]}; "
                    "store frames of one shape and type"
                )
            first = frame, dtype
            check_count(name, len(places) + count)
            places += [(info.filename, k) for k in range(count)]
    if first is None:
        raise InputError(f"{name}: holds no 2-D array; save frames of (rows, columns)")
    return Recording(
        "NumPy", first[0], first[1].newbyteorder("="), NpzFrames(path, tuple(places)),
        (metadata,) * len(places),
    )  # fmt: skip


def _scalar(
    file: IO[bytes], info: zipfile.ZipInfo, shape: tuple[int, ...], dtype: np.dtype
) -> Metadata:
    if shape != () or dtype.kind not in "iuf":
        return Metadata()
    value = np.frombuffer(file.read(dtype.itemsize), dtype, 1)[0]
    return from_header({info.filename.removesuffix(".npy"): float(value)})


def _header(file: IO[bytes], name: str) -> tuple[tuple[int, ...], bool, np.dtype]:
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
