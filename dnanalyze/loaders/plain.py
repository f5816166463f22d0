"""Uncompressed pixels at an offset of a file: what most formats are once the header is read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import check_length


@dataclass(frozen=True)
class PlainPixels:
    """Reads windows of uncompressed frames from disk.

    Parameters
    ----------
    path : Path
    offsets : sequence of int
        First byte of each frame.
    shape : tuple of int
        (rows, columns).
    dtype : str
        With byte order, such as ">i2".
    sign_flip : bool
        Stored signed, meant unsigned with half the range added (FITS BZERO).
    """

    path: Path
    offsets: Sequence[int]
    shape: tuple[int, int]
    dtype: str
    sign_flip: bool = False
    partial: ClassVar[bool] = True

    @property
    def frame_bytes(self) -> int:
        """Bytes of one frame."""
        return self.shape[0] * self.shape[1] * np.dtype(self.dtype).itemsize

    def check(self, name: str) -> None:
        """Refuse a file that ends before its last frame.

        Raises
        ------
        InputError
            Truncated.
        """
        check_length(name, max(self.offsets) + self.frame_bytes, self.path.stat().st_size)

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``, native byte order."""
        dtype, columns = np.dtype(self.dtype), self.shape[1]
        rows, width = window.shape
        if 2 * width >= columns or rows * columns <= 1 << 16:
            # whole rows in one read: faster than faulting in a map page by page
            start = self.offsets[index] + window.top * columns * dtype.itemsize
            stored = np.fromfile(self.path, dtype, rows * columns, offset=start)
            check_length(self.path.name, rows * columns * dtype.itemsize, stored.nbytes)
            array = stored.reshape(rows, columns)[:, window.left : window.right]
        else:
            mapped = np.memmap(self.path, dtype, "r", self.offsets[index], self.shape)
            array = np.array(mapped[window.slices])
        return self.native(array)

    def native(self, array: np.ndarray) -> np.ndarray:
        """Stored pixels, writable, in native byte order and with their sign."""
        if not array.dtype.isnative:
            array = array.byteswap(inplace=True).view(array.dtype.newbyteorder("="))
        if self.sign_flip:
            array = array.view(array.dtype.str.replace("i", "u"))
            array ^= array.dtype.type(1 << (8 * array.dtype.itemsize - 1))
        return array
