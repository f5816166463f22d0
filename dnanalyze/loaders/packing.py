"""Packed raw pixels to integers and back, vectorised, each the exact inverse of the other.

"mipi" is the byte order of CSI-2 (MIPI Alliance, CSI-2, data types RAW10, RAW12, RAW14): the
high eight bits of each pixel of a group, then the low bits of all of them, first pixel lowest.
"lsb" is one little-endian stream of bits, first pixel lowest. Rows begin on a byte.
"""

from __future__ import annotations

import math

import numpy as np

PACKED_BITS = (10, 12, 14)


def group_of(bits: int) -> tuple[int, int]:
    """(pixels, bytes) of the smallest group that ends on a byte: (4, 5), (2, 3), (4, 7)."""
    pixels = 8 // math.gcd(bits, 8)
    return pixels, pixels * bits // 8


def row_bytes(width: int, bits: int, packing: str) -> int:
    """Bytes of a row of ``width`` pixels, the last group filled up."""
    if packing == "plain" or bits in (8, 16):
        return width * (1 if bits <= 8 else 2)
    pixels, size = group_of(bits)
    return -(-width // pixels) * size


def unpack(rows: np.ndarray, width: int, bits: int, packing: str) -> np.ndarray:
    """Pixels of packed rows.

    Parameters
    ----------
    rows : ndarray of uint8, (rows, bytes)
        Whole groups; trailing bytes of a row are padding.
    width : int
        Pixels of a row.
    bits : int
        10, 12 or 14.
    packing : str
        "mipi" or "lsb".

    Returns
    -------
    ndarray of uint16, (rows, width)
    """
    pixels, size = group_of(bits)
    groups = -(-width // pixels)
    data = rows[:, : groups * size].reshape(len(rows), groups, size)
    out = np.empty((len(rows), groups, pixels), np.uint16)
    for pixel in range(pixels):
        if packing == "mipi":
            low = bits - 8
            value = data[:, :, pixel].astype(np.uint16) << low
            value |= _bit_field(data[:, :, pixels:], pixel * low, low)
        else:
            value = _bit_field(data, pixel * bits, bits)
        out[:, :, pixel] = value
    return out.reshape(len(rows), groups * pixels)[:, :width]


def pack(array: np.ndarray, bits: int, packing: str) -> np.ndarray:
    """Pixels to packed rows; the inverse of ``unpack``.

    Parameters
    ----------
    array : ndarray of integers, (rows, width)
        Values of 0 to ``2**bits - 1``.

    Returns
    -------
    ndarray of uint8, (rows, bytes)
    """
    pixels, size = group_of(bits)
    rows, width = array.shape
    groups = -(-width // pixels)
    padded = np.zeros((rows, groups * pixels), np.uint16)
    padded[:, :width] = array
    values = padded.reshape(rows, groups, pixels)
    out = np.zeros((rows, groups, size), np.uint8)
    for pixel in range(pixels):
        value = values[:, :, pixel]
        if packing == "mipi":
            low = bits - 8
            out[:, :, pixel] = value >> low
            _put_field(out[:, :, pixels:], pixel * low, low, value & ((1 << low) - 1))
        else:
            _put_field(out, pixel * bits, bits, value)
    return out.reshape(rows, groups * size)


def _bit_field(data: np.ndarray, start: int, length: int) -> np.ndarray:
    """Bits ``start`` to ``start + length`` of each little-endian run of bytes (last axis)."""
    value = np.zeros(data.shape[:-1], np.uint16)
    for byte in range(start // 8, (start + length - 1) // 8 + 1):
        shift = 8 * byte - start
        part = data[..., byte].astype(np.uint16)
        value |= part << shift if shift >= 0 else part >> -shift
    return value & np.uint16((1 << length) - 1)


def _put_field(data: np.ndarray, start: int, length: int, value: np.ndarray) -> None:
    for byte in range(start // 8, (start + length - 1) // 8 + 1):
        shift = 8 * byte - start
        part = value >> shift if shift >= 0 else value << -shift
        data[..., byte] |= (part & 255).astype(np.uint8)
