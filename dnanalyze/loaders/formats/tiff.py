"""TIFF: one page, many pages, or a stack; uncompressed pages are read from disk in parts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tifffile

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_dtype, check_length, check_memory, check_shape
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.headers import from_header, from_text
from dnanalyze.loaders.plain import PlainPixels
from dnanalyze.loaders.recording import Metadata, Recording

_MAX_PAGES = 1_000_000
_TAGS = ("ExposureTime", "ISOSpeedRatings", "AnalogGain")


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The header of a TIFF file."""
    with tifffile.TiffFile(path) as tif:
        pages = [p for p in _pages(tif) if not p.is_reduced]
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
        plain = _plain(path, tif, pages, shape)
        if plain is not None:
            plain.check(name)
        else:
            check_memory(name, 2 * shape[0] * shape[1] * np.dtype(dtype).itemsize)
        metadata = [_metadata(page) for page in pages]
        if plain is not None and len(plain.offsets) > len(metadata):
            metadata = metadata[:1] * len(plain.offsets)
        indices = tuple(page.index for page in pages)
    decode = plain if plain is not None else TiffPages(path, indices)
    return Recording("TIFF", shape, np.dtype(dtype), decode, tuple(metadata))


@dataclass(frozen=True)
class TiffPages:
    """Decodes compressed pages; ``pages`` are their numbers in the file."""

    path: Path
    pages: tuple[int, ...]

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of page ``index``."""
        number = self.pages[index]
        with tifffile.TiffFile(self.path) as tif:
            page = tif.pages[number]
            try:
                return page.asarray()[window.slices]
            except ValueError as error:  # tifffile leaves LZW and others to imagecodecs
                if "imagecodecs" not in str(error):
                    raise
        return _by_pillow(self.path, number)[window.slices]


def _by_pillow(path: Path, page: int) -> np.ndarray:
    """One page decoded by libtiff, through Pillow."""
    from PIL.TiffImagePlugin import TiffImageFile  # the plugin: our own bound stands for PIL's

    with TiffImageFile(path) as image:
        image.seek(page)
        return np.asarray(image)


def _pages(tif: tifffile.TiffFile) -> list[Any]:
    pages = tif.pages
    if len(pages) > _MAX_PAGES:
        raise ValueError(f"{len(pages)} pages")
    found = [pages[i] for i in range(len(pages))]
    if not found:
        raise ValueError("no page")
    return found


def _page_shape(page: Any, name: str) -> tuple[int, int]:
    if page.samplesperpixel > 1 or len(page.shape) != 2:
        raise InputError(f"{name}: is {page.shape}, a colour or volume image; give raw frames")
    return page.shape


def _plain(
    path: Path, tif: tifffile.TiffFile, pages: list[Any], shape: tuple[int, int]
) -> PlainPixels | None:
    """Where the pixels lie, if every page is one run of uncompressed bytes."""
    dtype = np.dtype(pages[0].dtype).newbyteorder(tif.byteorder)
    if not all(page.is_memmappable for page in pages):
        return None
    offsets = [page.dataoffsets[0] for page in pages]
    if len(pages) == 1:  # one page may head a stack (ImageJ over 4 GB, tifffile's truncate)
        series = tif.series[0]
        count = series.size // (shape[0] * shape[1])
        if count > 1 and series.dataoffset is not None:
            step = shape[0] * shape[1] * dtype.itemsize
            offsets = [series.dataoffset + k * step for k in range(count)]
    return PlainPixels(path, tuple(offsets), shape, dtype.str)


def _metadata(page: Any) -> Metadata:
    tags: dict[str, Any] = {}
    for tag in page.tags.values():
        if tag.name in _TAGS:
            tags[tag.name] = tag.value
        elif tag.name == "ExifTag" and isinstance(tag.value, dict):
            tags.update({k: v for k, v in tag.value.items() if k in _TAGS})
    found = from_header(tags)
    return found.or_else(from_text(page.description)) if page.description else found
