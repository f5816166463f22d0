"""HDF5: the 2-D or 3-D numeric datasets of one shape, with what lies on their way and beside.

Datasets whose names say mask, calibration or light (`dataset_names`) are no dark frames.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import (
    MAX_FRAMES,
    check_count,
    check_length,
    check_memory,
    check_stored,
)
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.formats.dataset_names import SCALARS, frames_of, is_mask, last
from dnanalyze.loaders.formats.numpy_files import stack_shape
from dnanalyze.loaders.headers import bayer_pattern, from_header
from dnanalyze.loaders.masks import gaps_of
from dnanalyze.loaders.recording import Metadata, Recording
from dnanalyze.loaders.stack_order import NOTE, doubtful, frames_last

_MAX_DATASETS = 10_000  # each is opened, in about 0.1 ms
_PARTS = 8  # of a frame: larger chunks are decoded once for the frame, and not for each part
_HELD = 1 << 26  # bytes
_PER_FRAME = ("temperature_c", "exposure_s", "gain")


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The datasets of an HDF5 file.

    Attributes of a dataset outrank those of its group, and those the file's. An attribute
    ``temperature_c``, ``exposure_s`` or ``gain`` may hold one value for each frame of a stack.
    """
    places: list[tuple[str, int, bool]] = []
    last_axis, small = False, True
    metadata: list[Metadata] = []
    first: tuple[tuple[int, int], np.dtype] | None = None
    with h5py.File(path, "r") as file:
        root = dict(file.attrs)
        found = _datasets(file, name)
        masks = [x for x in found if is_mask(x)]
        labels, note = frames_of([x for x in found if x not in masks])
        scalars = _scalars(file, labels)
        for label in labels:
            data = file[label]
            where = f"{name}: {label}"
            count, frame, turned = _order(where, data, config.frame_axis, path.stat().st_size)
            last_axis = last_axis or turned
            if first is not None and (frame, data.dtype) != first:
                raise InputError(
                    f"{where}: is {frame} {data.dtype}, the first dataset {first[0]} {first[1]}; "
                    "store frames of one shape and type"
                )
            first = frame, data.dtype
            size = frame[0] * frame[1] * data.dtype.itemsize
            check_memory(where, size + _chunk(data))
            small = small and _chunk(data) <= size // _PARTS
            attributes = root | _group_attributes(file, label) | dict(data.attrs)
            check_count(name, len(places) + count)
            places += [(label, k, turned) for k in range(count)]
            stated = [s for s in scalars if label.startswith(s.owner)]
            metadata += _metadata(attributes, count, stated)
    if first is None:
        raise InputError(f"{name}: holds no 2-D or 3-D numeric dataset; store frames in one")
    mask, told = _masked(path, masks, places[0], first)
    return Recording(
        "HDF5",
        first[0],
        first[1].newbyteorder("="),
        Datasets(path, tuple(places), small),
        tuple(metadata),
        cfa=bayer_pattern(_text(attributes.get("cfa", attributes.get("BAYERPAT", "")))),
        black_level=_number(attributes.get("black_level")),
        white_level=_number(attributes.get("white_level")),
        pixel_pitch_um=_number(attributes.get("pixel_pitch_um")),
        mask=mask,
        notes=tuple(text for text in (note, told, NOTE if last_axis else "") if text),
    )


@dataclass(frozen=True)
class Scalar:
    """A dataset that states something of the frames below ``owner``, a group with its "/"."""

    owner: str
    key: str
    values: np.ndarray
    unit: str


def _scalars(file: h5py.File, labels: Sequence[str]) -> list[Scalar]:
    """What small datasets state; of a detector's group it holds for the frames of its entry.

    The nearest group above, or around, that has frames owns it; those of nearer groups come last.
    """
    found: list[Scalar] = []

    def visit(label: str, item: Any) -> None:
        key = SCALARS.get(last(label))
        if key is None or not isinstance(item, h5py.Dataset) or item.dtype.kind not in "iuf":
            return
        if item.ndim > 1 or not 0 < item.size <= MAX_FRAMES or "sample/" in label:
            return  # the temperature of a sample is not the sensor's
        owner = label
        while owner:
            owner = owner.rpartition("/")[0]
            below = owner + "/" if owner else ""
            if any(x.startswith(below) for x in labels):
                break
        unit = str(_text(item.attrs.get("units", "")))[:20]
        found.append(Scalar(owner + "/" if owner else "", key, np.ravel(item[()]), unit))

    file.visititems(visit)
    return sorted(found, key=lambda s: s.owner.count("/"))


def _masked(
    path: Path,
    masks: list[str],
    place: tuple[str, int, bool],
    first: tuple[tuple[int, int], np.dtype],
) -> tuple[np.ndarray | None, str]:
    """The file's mask and the gaps of its first frame; None where neither masks anything."""
    shape, dtype = first
    masked, unused = np.zeros(shape, bool), ""
    with h5py.File(path, "r") as file:
        for label in masks:
            data = file[label]
            check_memory(label, masked.nbytes + _chunk(data))
            if data.shape == shape:
                masked |= np.asarray(data[()]) != 0
            elif data.ndim == 3 and data.shape[1:] == shape and data.shape[0] <= MAX_FRAMES:
                for k in range(data.shape[0]):  # one for each frame: what any of them marks
                    masked |= np.asarray(data[k]) != 0
            else:
                unused = f"The mask {label[:80]} has the shape {data.shape}, the frames {shape}; "
                unused += "not used."
        gaps = None
        if not masked.any() and dtype.kind in "iu":
            label, number, turned = place
            frame = file[label]
            if frame.ndim == 3:
                frame = frame[..., number] if turned else frame[number]
            gaps = gaps_of(np.asarray(frame))
    if gaps is not None:
        value = "the largest value" if dtype.kind == "u" else "negative values"
        return gaps, f"No mask is stored; pixels at {value} of {dtype} are taken as masked gaps."
    return (masked if masked.any() else None), unused


@dataclass(frozen=True)
class Datasets:
    """Frames of the datasets of a file: dataset, index in it, and whether that is the last axis.

    ``partial`` where a part of a frame lies in chunks that are small beside the frame.
    """

    path: Path
    places: tuple[tuple[str, int, bool], ...]
    partial: bool = True

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``; only the chunks that it touches are read."""
        label, number, turned = self.places[index]
        with h5py.File(self.path, "r") as file:
            data = file[label]
            if turned:
                return data[(*window.slices, number)]
            return data[window.slices] if data.ndim == 2 else data[(number, *window.slices)]


def _datasets(file: h5py.File, name: str) -> list[str]:
    datasets: list[str] = []

    def visit(label: str, item: Any) -> None:
        if len(datasets) > _MAX_DATASETS:
            raise InputError(f"{name}: more than {_MAX_DATASETS} datasets; split the file")
        if not isinstance(item, h5py.Dataset) or item.ndim not in (2, 3):
            return
        if item.dtype.kind in ("iufb" if is_mask(label) else "iuf"):
            datasets.append(label)

    file.visititems(visit)  # soft and external links are not followed
    return datasets


def _order(
    where: str, data: h5py.Dataset, asked: str | None, file_size: int
) -> tuple[int, tuple[int, int], bool]:
    """(frames, (rows, columns)), and whether the last axis counts the frames."""
    shape = data.shape
    turned = False
    if doubtful(shape):
        _check_storage(where, data, file_size)
        turned = frames_last(where, _held(data), asked)
        shape = (shape[2], *shape[:2]) if turned else shape
    count, frame = stack_shape(where, shape, False, data.dtype)
    _check_storage(where, data, file_size)
    return count, frame, turned


def _check_storage(where: str, data: h5py.Dataset, file_size: int) -> None:
    """Refuse pixels that lie elsewhere, are cut off, or are so few bytes that they hold no noise.

    Raises
    ------
    InputError
    """
    if data.external or data.is_virtual:
        raise InputError(f"{where}: keeps its pixels in another file; repack the dataset")
    pixels = int(np.prod(data.shape, dtype=object))
    size, offset = pixels * data.dtype.itemsize, None
    if data.chunks is None:
        offset = data.id.get_offset()
    if offset is not None:
        check_length(where, offset + size, file_size)
    else:
        check_stored(where, data.id.get_storage_size(), pixels, size)
    if data.chunks is not None:
        _check_chunks(where, data, _chunk(data), file_size)


def _chunk(data: h5py.Dataset) -> int:
    """Bytes of a chunk, decoded; 0 where there are none."""
    return int(np.prod(data.chunks, dtype=object)) * data.dtype.itemsize if data.chunks else 0


def _held(data: h5py.Dataset) -> Any:
    """The values of a small dataset in chunks, so that these are decoded once."""
    held = data.chunks is not None and data.size * data.dtype.itemsize <= _HELD
    return data[()] if held else data


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


def _metadata(
    attributes: Mapping[str, Any], count: int, scalars: Sequence[Scalar] = ()
) -> list[Metadata]:
    lists = {k: v for k, v in attributes.items() if k in _PER_FRAME and np.shape(v) == (count,)}
    plain = {k: _text(v) for k, v in attributes.items() if np.ndim(v) == 0}
    own = [from_header(plain | {k: v[i] for k, v in lists.items()}) for i in range(count)]
    near = [s for s in scalars if s.values.size in (1, count)]
    units = {s.key: f"[{s.unit}]" for s in near}
    beside = [
        from_header({s.key: float(s.values[min(i, s.values.size - 1)]) for s in near}, units)
        for i in range(count)
    ]
    return [mine.or_else(theirs) for mine, theirs in zip(own, beside, strict=True)]


def _text(value: Any) -> Any:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float, np.number)) else None
