"""HDF5: every 2-D or 3-D numeric dataset of one shape, with the attributes on its way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import h5py
import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_count, check_length, check_memory, check_stored
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.files import natural_key
from dnanalyze.loaders.formats.numpy_files import stack_shape
from dnanalyze.loaders.headers import bayer_pattern, from_header
from dnanalyze.loaders.recording import Metadata, Recording

_MAX_DATASETS = 10_000  # each is opened, in about 0.1 ms
_PER_FRAME = ("temperature_c", "exposure_s", "gain")


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The datasets of an HDF5 file.

    Attributes of a dataset outrank those of its group, and those the file's. An attribute
    ``temperature_c``, ``exposure_s`` or ``gain`` may hold one value for each frame of a stack.
    """
    places: list[tuple[str, int]] = []
    metadata: list[Metadata] = []
    first: tuple[tuple[int, int], np.dtype] | None = None
    with h5py.File(path, "r") as file:
        root = dict(file.attrs)
        for label in _datasets(file, name):
            data = file[label]
            where = f"{name}: {label}"
            count, frame = stack_shape(where, data.shape, False, data.dtype)
            if first is not None and (frame, data.dtype) != first:
                raise InputError(
                    f"{where}: is {frame} {data.dtype}, the first dataset {first[0]} {first[1]}; "
                    "store frames of one shape and type"
                )
            first = frame, data.dtype
            if data.external or data.is_virtual:
                raise InputError(f"{where}: keeps its pixels in another file; repack the dataset")
            pixels = frame[0] * frame[1]
            size = pixels * data.dtype.itemsize
            if data.chunks is None:
                offset = data.id.get_offset()
                if offset is not None:
                    check_length(where, offset + count * size, path.stat().st_size)
                else:
                    check_stored(where, data.id.get_storage_size(), count * pixels, count * size)
            else:
                check_stored(where, data.id.get_storage_size(), count * pixels, count * size)
                chunk = int(np.prod(data.chunks, dtype=np.int64)) * data.dtype.itemsize
                check_memory(where, size + chunk)
                _check_chunks(where, data, chunk, path.stat().st_size)
            attributes = root | _group_attributes(file, label) | dict(data.attrs)
            check_count(name, len(places) + count)
            places += [(label, k) for k in range(count)]
            metadata += _metadata(attributes, count)
    if first is None:
        raise InputError(f"{name}: holds no 2-D or 3-D numeric dataset; store frames in one")
    return Recording(
        "HDF5",
        first[0],
        first[1].newbyteorder("="),
        Datasets(path, tuple(places)),
        tuple(metadata),
        cfa=bayer_pattern(_text(attributes.get("cfa", attributes.get("BAYERPAT", "")))),
        black_level=_number(attributes.get("black_level")),
        white_level=_number(attributes.get("white_level")),
        pixel_pitch_um=_number(attributes.get("pixel_pitch_um")),
    )


@dataclass(frozen=True)
class Datasets:
    """Frames of the datasets of a file: (dataset, index in it) for each."""

    path: Path
    places: tuple[tuple[str, int], ...]
    partial: ClassVar[bool] = True

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``; only the chunks that it touches are read."""
        label, number = self.places[index]
        with h5py.File(self.path, "r") as file:
            data = file[label]
            return data[window.slices] if data.ndim == 2 else data[(number, *window.slices)]


def _datasets(file: h5py.File, name: str) -> list[str]:
    datasets: list[str] = []

    def visit(label: str, item: Any) -> None:
        if len(datasets) > _MAX_DATASETS:
            raise InputError(f"{name}: more than {_MAX_DATASETS} datasets; split the file")
        if isinstance(item, h5py.Dataset) and item.ndim in (2, 3) and item.dtype.kind in "iuf":
            datasets.append(label)

    file.visititems(visit)  # soft and external links are not followed
    return sorted(datasets, key=natural_key)


def _check_chunks(where: str, data: h5py.Dataset, chunk: int, file_size: int) -> None:
    """Refuse chunks whose place in the file cannot be; the library would return stray memory.

    Raises
    ------
    InputError
        A chunk beyond the end of the file, or stored as it is in too few bytes.
    """
    filters = (1 << data.id.get_create_plist().get_nfilters()) - 1

    def check(info: Any) -> None:
        plain = info.filter_mask & filters == filters
        wrong = info.size != chunk if plain else info.size == 0
        if wrong or info.byte_offset + info.size > file_size:
            raise InputError(f"{where}: a chunk of it is cut off; copy the file again")

    if hasattr(data.id, "chunk_iter"):  # HDF5 before 1.12.3 has none
        data.id.chunk_iter(check)


def _group_attributes(file: h5py.File, label: str) -> dict[str, Any]:
    attributes: dict[str, Any] = {}
    parts = label.split("/")[:-1]
    for depth in range(1, len(parts) + 1):
        attributes |= dict(file["/".join(parts[:depth])].attrs)
    return attributes


def _metadata(attributes: Mapping[str, Any], count: int) -> list[Metadata]:
    lists = {k: v for k, v in attributes.items() if k in _PER_FRAME and np.shape(v) == (count,)}
    plain = {k: _text(v) for k, v in attributes.items() if np.ndim(v) == 0}
    return [from_header(plain | {k: v[i] for k, v in lists.items()}) for i in range(count)]


def _text(value: Any) -> Any:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float, np.number)) else None
