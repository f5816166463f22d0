"""Packed raw pixels to integers and back, vectorised, each the exact inverse of the other.

"mipi" is the byte order of CSI-2 (MIPI Alliance, CSI-2, data types RAW10, RAW12, RAW14): the
high eight bits of each pixel of a group, then the low bits of all of them, first pixel lowest.
"lsb" is one little-endian stream of bits, first pixel lowest (Mono10p, Mono12p of the GenICam
PFNC); "msb" one big-endian stream, first pixel highest (TIFF). "genicam" is Mono10Packed and
Mono12Packed of GigE Vision: the high eight bits of two pixels, and a byte of their low bits between
them. Rows begin on a byte.
"""

from __future__ import annotations

import math

import numpy as np

PACKED_BITS = (10, 12, 14)
PACKINGS = {"mipi": PACKED_BITS, "lsb": PACKED_BITS, "msb": PACKED_BITS, "genicam": (10, 12)}


def group_of(bits: int, packing: str) -> tuple[int, int]:
    """(pixels, bytes) of the smallest group that ends on a byte: (4, 5), (2, 3), (4, 7)."""
    if packing == "genicam":
        return 2, 3
    pixels = 8 // math.gcd(bits, 8)
    return pixels, pixels * bits // 8


def row_bytes(width: int, bits: int, packing: str) -> int:
    """Bytes of a row of ``width`` pixels, the last group filled up."""
    if packing == "plain" or bits in (8, 16):
        return width * (1 if bits <= 8 else 2)
    pixels, size = group_of(bits, packing)
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
        One of ``PACKINGS``.

    Returns
    -------
    ndarray of uint16, (rows, width)
    """
    pixels, size = group_of(bits, packing)
    groups = -(-width // pixels)
    data = rows[:, : groups * size].reshape(len(rows), groups, size)
    if packing == "msb":
        data = data[..., ::-1]
    out = np.zeros((len(rows), groups, pixels), np.uint16)
    for pixel in range(pixels):
        for start, length, shift in _fields(pixel, bits, packing):
            out[:, :, pixel] |= _bit_field(data, start, length) << np.uint16(shift)
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
    pixels, size = group_of(bits, packing)
    rows, width = array.shape
    groups = -(-width // pixels)
    padded = np.zeros((rows, groups * pixels), np.uint16)
    padded[:, :width] = array
    values = padded.reshape(rows, groups, pixels)
    out = np.zeros((rows, groups, size), np.uint8)
    for pixel in range(pixels):
        for start, length, shift in _fields(pixel, bits, packing):
            part = values[:, :, pixel] >> shift & ((1 << length) - 1)
            _put_field(out, start, length, part)
    if packing == "msb":
        out = out[..., ::-1]
    return out.reshape(rows, groups * size)


def _fields(pixel: int, bits: int, packing: str) -> tuple[tuple[int, int, int], ...]:
    """The runs of bits of a group that make a pixel: (first bit, length, place in the pixel).

    Bits are counted from the lowest of the first byte; of "msb" the bytes are reversed.
    """
    pixels, _ = group_of(bits, packing)
    low = bits - 8
    if packing == "mipi":
        return (8 * pixel, 8, low), (8 * pixels + pixel * low, low, 0)
    if packing == "genicam":
        return (16 * pixel, 8, low), (8 + 4 * pixel, low, 0)
    place = pixels - 1 - pixel if packing == "msb" else pixel
    return ((place * bits, bits, 0),)


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
