"""Uncompressed TIFF of 10, 12 or 14 bits a sample: a big-endian bit stream (TIFF 6.0)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dnanalyze.errors import InputError
from dnanalyze.loaders.checks import check_length
from dnanalyze.loaders.formats.headerless import RawRows
from dnanalyze.loaders.packing import PACKED_BITS

FILL_ORDER, PLAIN = 266, 1


def packed_bits(page: Any) -> int | None:
    """Bits of a sample, where samples of one page are packed and nothing else is done to them."""
    packed = page.bitspersample in PACKED_BITS and page.samplesperpixel == 1
    return int(page.bitspersample) if packed and page.compression == PLAIN else None


def packed_pages(path: Path, pages: Sequence[Any], shape: tuple[int, int], name: str) -> RawRows:
    """What reads packed pages.

    Raises
    ------
    InputError
        Tiles, strips that do not follow one another, another order of bits, or a file cut short.
    """
    bits = int(pages[0].bitspersample)
    stride = row_bytes_exact(shape[1], bits)
    offsets = []
    for page in pages:
        order = page.tags.get(FILL_ORDER)
        starts, counts = list(page.dataoffsets), list(page.databytecounts)
        together = all(a + c == b for a, c, b in zip(starts, counts, starts[1:], strict=False))
        if page.is_tiled or not together or not starts or (order is not None and order.value != 1):
            raise InputError(
                f"{name}: holds {bits}-bit samples in tiles, scattered strips or reversed bits; "
                "store them as 16-bit TIFF"
            )
        check_length(name, starts[0] + shape[0] * stride, path.stat().st_size)
        offsets.append(int(starts[0]))
    return RawRows(path, tuple(offsets), shape[1], stride, bits, "msb", np.dtype("<u2").str)


def row_bytes_exact(width: int, bits: int) -> int:
    """Bytes of a row: as many as its bits need, without a whole last group."""
    return -(-width * bits // 8)
