"""What is refused before pixels are decoded, and what is refused once they are seen."""

from __future__ import annotations

import os

import numpy as np

from dnanalyze.errors import InputError

MAX_PIXELS = 1 << 30  # a frame; the largest sensors made have about half of that
MAX_FRAMES = 100_000  # of a file; each takes about 1 kB once it is listed
# A statistic of lines, spectra or neighbours needs 8 x 8 pixels; a fit is made on the upper half
# of the rows and judged on the lower half; each colour of a mosaic is analysed by itself.
MIN_ROWS, MIN_COLUMNS = 16, 8
MAX_CODE = 1 << 24  # DN; single precision tells whole numbers apart up to here
# Noise in one pixel of a hundred is at least 0.08 bit a pixel (the entropy of a choice with
# probability .01), whatever the code: fewer stored bits than half of that hold no frame.
MIN_BITS = 0.04
_SMALL = 64 << 20  # bytes that may be decoded without that question
_PROBE = 64  # a constant window smaller than this says nothing of its frame


def check_shape(name: str, shape: tuple[int, ...], mosaic: bool = False) -> None:
    """Refuse a declared frame that is too small to analyse or too large to be true.

    Parameters
    ----------
    name : str
        For the message.
    shape : tuple of int
        (rows, columns).
    mosaic : bool
        Whether a colour filter divides it into planes.

    Raises
    ------
    InputError
        Fewer rows or columns than the least, or more than ``MAX_PIXELS`` pixels.
    """
    rows, columns = shape
    least = (2 * MIN_ROWS, 2 * MIN_COLUMNS) if mosaic else (MIN_ROWS, MIN_COLUMNS)
    if rows < least[0] or columns < least[1]:
        kind = "frames with a colour filter" if mosaic else "frames"
        raise InputError(
            f"{name}: {rows} x {columns} pixels are too few to analyse; "
            f"give {kind} of at least {least[0]} rows x {least[1]} columns"
        )
    if rows * columns > MAX_PIXELS:
        raise InputError(
            f"{name}: declares {rows} x {columns} pixels, more than {MAX_PIXELS}; "
            "the header is damaged, or the file must be cut into smaller frames"
        )


def check_count(name: str, count: int) -> None:
    """Refuse a file that declares more frames than can be listed, before they are.

    Raises
    ------
    InputError
        More than ``MAX_FRAMES``, or none.
    """
    if not 0 < count <= MAX_FRAMES:
        raise InputError(
            f"{name}: declares {count} frames; valid: 1 to {MAX_FRAMES} in one file: the header "
            "is damaged, or the file must be split"
        )


def check_stored(name: str, stored: int, pixels: int, size: int) -> None:
    """Refuse compressed pixels that take so few bytes that they cannot hold noise.

    Parameters
    ----------
    name : str
        For the message.
    stored : int
        Compressed bytes.
    pixels : int
        That they decode to.
    size : int
        Bytes of these.

    Raises
    ------
    InputError
        Much is to be decoded from less than ``MIN_BITS`` a pixel.
    """
    if size > _SMALL and 8 * stored < MIN_BITS * pixels:
        raise InputError(
            f"{name}: {stored} bytes decode to {pixels} pixels, less than {MIN_BITS} bit each; "
            "such frames hold no noise, or the header is damaged: leave the file out"
        )


def check_memory(name: str, size: int) -> None:
    """Refuse a frame whose decoded bytes exceed the memory that is free.

    Raises
    ------
    InputError
        ``size`` bytes do not fit; nothing has been decoded yet.
    """
    free = available_memory()
    if free is not None and size > free:
        raise InputError(
            f"{name}: needs {size / 1e9:.1f} GB to decode and {free / 1e9:.1f} GB are free; "
            "store it uncompressed, which is read in parts, or use a larger machine"
        )


def available_memory() -> int | None:
    """Bytes that can be taken without swapping; None where the system does not say."""
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            for line in lines:
                if line.startswith("MemAvailable:"):
                    return int(line.split()[1]) * 1024
    except (OSError, ValueError):
        pass
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None


def check_length(name: str, needed: int, present: int) -> None:
    """Refuse a file that ends before its declared pixels do.

    Raises
    ------
    InputError
        ``present`` bytes are fewer than ``needed``.
    """
    if present < needed:
        raise InputError(
            f"{name}: truncated, {present} bytes of the {needed} that its header declares; "
            "copy the file again or leave it out"
        )


def check_dtype(name: str, dtype: np.dtype) -> None:
    """Refuse pixels that are neither integer nor real.

    Raises
    ------
    InputError
        Boolean, complex, text or object pixels.
    """
    if dtype.kind not in "iuf":
        raise InputError(
            f"{name}: pixels of type {dtype} are not numbers of counts; store integers or floats"
        )


def is_constant(array: np.ndarray) -> bool:
    """True when all pixels are equal; looks beyond the first row only where that is constant."""
    first = array.flat[0]
    return bool((array[0] == first).all() and (array == first).all())


def check_range(name: str, array: np.ndarray) -> None:
    """Refuse NaN, infinity and codes that single precision cannot tell apart.

    Raises
    ------
    InputError
        A pixel is not finite, or beyond ``MAX_CODE``; the first one is named.
    """
    if array.dtype.kind != "f" and array.dtype.itemsize <= 2:
        return
    low, high = array.min(), array.max()  # either is NaN where a pixel is
    if low >= -MAX_CODE and high <= MAX_CODE:
        return
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        row, column = bad[0]
        raise InputError(
            f"{name}: {len(bad)} pixels are NaN or infinite, the first at row {row}, column "
            f"{column}; store the raw counts, without masked pixels"
        )
    raise InputError(
        f"{name}: values from {low:g} to {high:g} DN; valid: -{MAX_CODE} to {MAX_CODE}, which "
        "single precision holds exactly: store the raw codes, or subtract a constant"
    )


def check_pixels(name: str, array: np.ndarray) -> None:
    """Refuse a whole frame that carries no noise, or no numbers.

    Parameters
    ----------
    name : str
        File of the frame, for the message.
    array : ndarray, (rows, columns)
        All pixels of the frame, DN.

    Raises
    ------
    InputError
        As `check_range`; all pixels zero, or all pixels equal.
    """
    check_range(name, array)
    if not is_constant(array):
        return
    value = array.flat[0]
    if value == 0:
        raise InputError(
            f"{name}: all pixels are zero; the black level was clipped away or the frame was "
            "never written: record with a pedestal, or leave the file out"
        )
    raise InputError(
        f"{name}: all pixels equal {value:g}; a frame without noise cannot be analysed: "
        "leave the file out"
    )


def worth_a_look(window: np.ndarray) -> bool:
    """True for a constant window that is large enough to suspect the whole frame."""
    return window.size >= _PROBE and is_constant(window)
