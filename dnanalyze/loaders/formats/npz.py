"""NumPy ``.npz``: 2-D frames, 3-D stacks, a mask and scalars by name; never pickles."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_count, check_memory, check_stored
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.formats.dataset_names import frames_of, is_mask
from dnanalyze.loaders.formats.numpy_files import header, stack_shape
from dnanalyze.loaders.headers import from_header
from dnanalyze.loaders.recording import Metadata, Recording
from dnanalyze.loaders.stack_order import NOTE, doubtful, frames_last


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The arrays of an ``.npz`` file; their names mean what those of HDF5 datasets do."""
    found: dict[str, _Member] = {}
    metadata = Metadata()
    with zipfile.ZipFile(path) as archive:
        check_count(name, len(archive.infolist()))
        for info in archive.infolist():
            label = info.filename.removesuffix(".npy")
            with archive.open(info) as file:
                shape, fortran, dtype = header(file, f"{name}: {info.filename}")
                if len(shape) < 2:
                    metadata = metadata.or_else(_scalar(file, label, shape, dtype))
                    continue
                found[label] = _Member(info, shape, fortran, dtype, file.tell())
    masks = [x for x in found if is_mask(x)]
    taken, note = frames_of([x for x in found if x not in masks])
    if not taken:
        raise InputError(f"{name}: holds no 2-D array; save frames of (rows, columns)")
    places: list[tuple[str, int]] = []
    last_axis = False
    first: tuple[tuple[int, int], np.dtype] | None = None
    for member in (found[x] for x in found if x in taken):
        where = f"{name}: {member.info.filename}"
        count, frame, turned = _order(path, where, member, config.frame_axis)
        last_axis = last_axis or turned
        if first is not None and (frame, member.dtype) != first:
            raise InputError(
                f"{where}: is {frame} {member.dtype}, the first array {first[0]} {first[1]}; "
                "store frames of one shape and type"
            )
        first = frame, member.dtype
        check_count(name, len(places) + count)
        places += [(member.info.filename, -1 - k if turned else k) for k in range(count)]
    assert first is not None
    return Recording(
        "NumPy", first[0], first[1].newbyteorder("="), NpzFrames(path, tuple(places)),
        (metadata,) * len(places),
        mask=_mask(path, name, [found[x] for x in masks], first[0]),
        notes=tuple(text for text in (note, NOTE if last_axis else "") if text),
    )  # fmt: skip


@dataclass(frozen=True)
class _Member:
    """One array of the archive; its pixels begin at ``start`` of the unpacked member."""

    info: zipfile.ZipInfo
    shape: tuple[int, ...]
    fortran: bool
    dtype: np.dtype
    start: int


@dataclass(frozen=True)
class NpzFrames:
    """Frames of the arrays of an ``.npz``: (member, number in it) for each.

    Number k of an array whose last axis counts the frames is given as -1 - k.
    """

    path: Path
    places: tuple[tuple[str, int], ...]

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``; the member is read up to that frame only."""
        member, number = self.places[index]
        with zipfile.ZipFile(self.path) as archive, archive.open(member) as file:
            shape, _, dtype = header(file, member)
            if number < 0:
                return _values(file, shape, dtype)[(*window.slices, -1 - number)]
            frame = shape[-2:]
            file.seek(number * frame[0] * frame[1] * dtype.itemsize, 1)
            return _values(file, frame, dtype)[window.slices]


def _order(
    path: Path, where: str, member: _Member, asked: str | None
) -> tuple[int, tuple[int, int], bool]:
    """(frames, (rows, columns)) of an array, and whether its last axis counts the frames."""
    shape, info = member.shape, member.info
    turned = False
    if doubtful(shape) and member.dtype.kind in "iuf" and not member.fortran:
        _check(where, member)
        check_memory(where, 2 * _size(member))
        with zipfile.ZipFile(path) as archive, archive.open(info) as file:
            file.seek(member.start)
            turned = frames_last(where, _values(file, shape, member.dtype), asked)
    if turned:
        shape = (shape[2], *shape[:2])
    count, frame = stack_shape(where, shape, member.fortran, member.dtype)
    _check(where, member)
    if not turned:
        check_memory(where, 2 * _size(member) // count)
    return count, frame, turned


def _check(where: str, member: _Member) -> None:
    """Refuse what is cut off, or holds no noise."""
    if member.info.file_size < member.start + _size(member):
        raise InputError(f"{where}: truncated; write the file again")
    pixels = _size(member) // member.dtype.itemsize
    check_stored(where, member.info.compress_size, pixels, _size(member))


def _size(member: _Member) -> int:
    """Bytes of the pixels."""
    return int(np.prod(member.shape, dtype=object)) * member.dtype.itemsize


def _values(file: IO[bytes], shape: tuple[int, ...], dtype: np.dtype) -> np.ndarray:
    count = int(np.prod(shape, dtype=object))
    return np.frombuffer(file.read(count * dtype.itemsize), dtype, count).reshape(shape)


def _mask(
    path: Path, name: str, members: list[_Member], shape: tuple[int, int]
) -> np.ndarray | None:
    """What the masks of the shape of the frames mark; None where they mark nothing."""
    masked = np.zeros(shape, bool)
    with zipfile.ZipFile(path) as archive:
        for member in members:
            if member.shape == shape and not member.fortran and member.dtype.kind in "buif":
                _check(f"{name}: {member.info.filename}", member)
                with archive.open(member.info) as file:
                    file.seek(member.start)
                    masked |= _values(file, shape, member.dtype) != 0
    return masked if masked.any() else None


def _scalar(file: IO[bytes], label: str, shape: tuple[int, ...], dtype: np.dtype) -> Metadata:
    if shape != () or dtype.kind not in "iuf":
        return Metadata()
    return from_header({label: float(_values(file, (), dtype))})
