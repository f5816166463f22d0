"""TIFF: one page, many pages, or a stack; uncompressed pages are read from disk in parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tifffile

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
from dnanalyze.loaders.formats.tiff_metadata import imagej, micro_manager, ome
from dnanalyze.loaders.formats.tiff_packed import packed_bits, packed_pages
from dnanalyze.loaders.grey import PROCESSED, check_grey
from dnanalyze.loaders.headers import from_header, from_text
from dnanalyze.loaders.plain import PlainPixels
from dnanalyze.loaders.recording import Metadata, Recording, one_line

_TAGS = ("ExposureTime", "ISOSpeedRatings", "AnalogGain")


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The header of a TIFF file."""
    with tifffile.TiffFile(path) as tif:
        pages = [p for p in _pages(tif, name) if not p.is_reduced]
        if not pages:
            raise InputError(f"{name}: holds previews alone; give raw frames")
        first = pages[0]
        shape, dtype = _page_shape(first, name), first.dtype
        check_shape(name, shape)
        for number, page in enumerate(pages):
            if page.shape != first.shape or page.dtype != dtype:
                raise InputError(
                    f"{name}: page {number} is {page.shape} {page.dtype}, the first is "
                    f"{first.shape} {dtype}; store one shape of frame a file"
                )
        if dtype is None:
            raise InputError(f"{name}: pixels of a kind that cannot be read; store uint16")
        check_dtype(name, np.dtype(dtype))
        size = path.stat().st_size
        for page in pages:
            ends = [o + c for o, c in zip(page.dataoffsets, page.databytecounts, strict=False)]
            check_length(name, max(ends, default=0), size)
        plain = _plain(path, tif, pages, shape, name)
        bits = packed_bits(first)
        packed = packed_pages(path, pages, shape, name) if bits else None
        if plain is not None:
            plain.check(name)
        elif packed is None:
            pixels = shape[0] * shape[1]
            decoded = pixels * np.dtype(dtype).itemsize * first.samplesperpixel
            check_memory(name, 2 * decoded)
            for page in pages:
                stored = min(size, sum(page.databytecounts))  # tiles may share their bytes
                check_stored(name, stored, pixels, decoded)
        metadata = [_metadata(page) for page in pages]
        if plain is not None and len(plain.offsets) > len(metadata):
            metadata = metadata[:1] * len(plain.offsets)
        text = first.description or ""
        stated = ome(text, len(metadata)) if tif.is_ome else imagej(text, len(metadata))
        if stated:
            metadata = [a.or_else(b) for a, b in zip(stated, metadata, strict=True)]
        indices = tuple(page.index for page in pages)
        notes = _grey_notes(path, pages, name) if first.samplesperpixel > 1 else ()
    decode = plain or packed or TiffPages(path, indices)
    return Recording(
        "TIFF", shape, np.dtype(dtype), decode, tuple(metadata), notes=notes, bits=bits
    )


@dataclass(frozen=True)
class TiffPages:
    """Decodes compressed pages; ``pages`` are their numbers in the file."""

    path: Path
    pages: tuple[int, ...]

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of page ``index``."""
        number = self.pages[index]
        with tifffile.TiffFile(self.path) as tif:
            page: Any = tif.pages[number]
            try:
                return colour_first(page.asarray(), page)[window.slices]
            except ValueError as error:  # tifffile leaves LZW and others to imagecodecs
                if "imagecodecs" not in str(error):
                    raise
        try:
            return _by_pillow(self.path, number)[window.slices]
        except (OSError, ValueError, SyntaxError, KeyError) as error:
            raise InputError(
                f"{self.path.name}: its compression or packing is not decoded here "
                f"({one_line(error)}); install imagecodecs, or store it as plain 16-bit TIFF"
            ) from error


def colour_first(array: np.ndarray, page: Any) -> np.ndarray:
    """The first channel of a page, which may have but one."""
    if page.samplesperpixel == 1:
        return array
    return array[0] if page.planarconfig == tifffile.PLANARCONFIG.SEPARATE else array[..., 0]


def _grey_notes(path: Path, pages: list[Any], name: str) -> tuple[str, ...]:
    """That the colour pages are grey ones in disguise, which is seen by decoding them."""
    for page in pages:
        array = page.asarray()
        planar = page.planarconfig == tifffile.PLANARCONFIG.SEPARATE
        check_grey(name, np.moveaxis(array, 0, -1) if planar else array)
    return (PROCESSED,)


def _by_pillow(path: Path, page: int) -> np.ndarray:
    """One page decoded by libtiff, through Pillow."""
    from PIL.TiffImagePlugin import TiffImageFile  # the plugin: our own bound stands for PIL's

    with TiffImageFile(path) as image:
        image.seek(page)
        array = np.asarray(image)
        return array if array.ndim == 2 else array[..., 0]


def _pages(tif: tifffile.TiffFile, name: str) -> list[Any]:
    check_count(name, len(tif.pages))
    return [tif.pages[i] for i in range(len(tif.pages))]


def _page_shape(page: Any, name: str) -> tuple[int, int]:
    rgb = page.photometric == tifffile.PHOTOMETRIC.RGB
    if rgb and page.samplesperpixel in (3, 4) and len(page.shape) == 3:
        return page.imagelength, page.imagewidth
    if page.samplesperpixel > 1 or len(page.shape) != 2:
        raise InputError(f"{name}: is {page.shape}, a colour or volume image; give raw frames")
    return page.shape


def _plain(
    path: Path, tif: tifffile.TiffFile, pages: list[Any], shape: tuple[int, int], name: str
) -> PlainPixels | None:
    """Where the pixels lie, if every page is one run of uncompressed bytes."""
    dtype = np.dtype(pages[0].dtype).newbyteorder(tif.byteorder)
    if not all(page.is_memmappable and page.samplesperpixel == 1 for page in pages):
        return None
    offsets: Sequence[int] = tuple(page.dataoffsets[0] for page in pages)
    # one page may head a stack (ImageJ over 4 GB, tifffile's truncate)
    if len(pages) == 1 and (tif.is_imagej or tif.is_shaped):
        series = tif.series[0]
        count = series.size // (shape[0] * shape[1])
        if count > 1 and series.dataoffset is not None:
            check_count(name, count)
            step = shape[0] * shape[1] * dtype.itemsize
            offsets = range(series.dataoffset, series.dataoffset + count * step, step)
    return PlainPixels(path, offsets, shape, dtype.str)


def _metadata(page: Any) -> Metadata:
    tags: dict[str, Any] = {}
    for tag in page.tags.values():
        if tag.name in _TAGS:
            tags[tag.name] = tag.value
        elif tag.name == "ExifTag" and isinstance(tag.value, dict):
            tags.update({k: v for k, v in tag.value.items() if k in _TAGS})
    metadata = micro_manager(page).or_else(from_header(tags))
    return metadata.or_else(from_text(page.description)) if page.description else metadata
