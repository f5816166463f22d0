"""Frames of FITS files that are packed: the whole file by gzip, or the image in tiles."""

from __future__ import annotations

import gzip
import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from astropy.io import fits

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_length
from dnanalyze.loaders.formats.fits_units import whole
from dnanalyze.loaders.plain import PlainPixels

MAX_SIDE = 1 << 17  # pixels of a tile; the widest sensors have a quarter of that

# Two decoders (of CFITSIO, in astropy) cannot be trusted with a damaged tile: that of HCOMPRESS_1
# writes out of bounds and ends the process, that of PLIO_1 leaves pixels of the tile unset.
ALGORITHMS = ("RICE_1", "RICE_ONE", "GZIP_1", "GZIP_2", "NOCOMPRESS")


@dataclass(frozen=True)
class GzipPixels:
    """Windows of the frames of a gzipped file; what lies before them is unpacked and dropped."""

    plain: PlainPixels

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``, native byte order."""
        plain, dtype = self.plain, np.dtype(self.plain.dtype)
        rows, columns = window.shape[0], plain.shape[1]
        size = rows * columns * dtype.itemsize
        data = bytearray(size)
        with gzip.open(plain.path) as file:
            file.seek(plain.offsets[index] + window.top * columns * dtype.itemsize)
            present = file.readinto(data)
        check_length(plain.path.name, size, present)
        array = np.frombuffer(data, dtype).reshape(rows, columns)
        return plain.native(array[:, window.left : window.right])


@dataclass(frozen=True)
class TilePixels:
    """Windows of the frames of a tile-compressed image; only the tiles that they touch are read.

    Parameters
    ----------
    path : Path
    unit : int
        Number of the unit in the file.
    ndim : int
        Axes of the image.
    outer : tuple of int
        Lengths of the axes before the rows.
    """

    path: Path
    unit: int
    ndim: int
    outer: tuple[int, ...]

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``, scaled as the header says."""
        before = np.unravel_index(index, self.outer) if self.outer else ()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what is wrong is seen in the pixels
            with fits.open(self.path, memmap=False) as hdus:
                return np.asarray(hdus[self.unit].section[(*map(int, before), *window.slices)])


def check_tiles(header: fits.Header, axes: Sequence[int], name: str) -> None:
    """Refuse a table of tiles that does not cover the image once, or that is not safe to decode.

    Raises
    ------
    InputError
        Tiles larger than any image, or too few or many of them, or an algorithm of another name.
    """
    how = str(header.get("ZCMPTYPE", "")).strip()
    if how not in ALGORITHMS:
        raise InputError(
            f"{name}: ZCMPTYPE = {how[:20]!r}; valid: {', '.join(ALGORITHMS)}; decompress it with "
            "funpack"
        )
    tiles = 1
    for k, length in enumerate(reversed(axes), 1):
        side = whole(header, f"ZTILE{k}", length if k == 1 else 1)
        # beyond the image is allowed: astropy writes such tiles where the image is small
        if not 1 <= side <= MAX_SIDE:
            raise InputError(f"{name}: ZTILE{k} = {side}; valid: 1 to {MAX_SIDE}: damaged header")
        tiles *= math.ceil(length / side)
    if whole(header, "NAXIS2") != tiles:
        raise InputError(
            f"{name}: holds {whole(header, 'NAXIS2')} tiles where its image has {tiles}; damaged: "
            "copy the file again"
        )
