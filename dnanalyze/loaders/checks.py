"""What is refused before pixels are decoded, and what is refused once they are seen."""

from __future__ import annotations

import os

import numpy as np

from dnanalyze.errors import InputError

MAX_PIXELS = 1 << 30  # a frame; the largest sensors made have about half of that
MIN_SIDE = 8  # pixels; fewer carry no statistics of lines, spectra or neighbours
_PROBE = 64  # a constant window smaller than this says nothing of its frame


def check_shape(name: str, shape: tuple[int, ...]) -> None:
    """Refuse a declared frame that is too small to analyse or too large to be true.

    Raises
    ------
    InputError
        Fewer than ``MIN_SIDE`` rows or columns, or more than ``MAX_PIXELS`` pixels.
    """
    rows, columns = shape
    if min(rows, columns) < MIN_SIDE:
        raise InputError(
            f"{name}: {rows} x {columns} pixels are too few to analyse; "
            f"give frames of at least {MIN_SIDE} x {MIN_SIDE}"
        )
    if rows * columns > MAX_PIXELS:
        raise InputError(
            f"{name}: declares {rows} x {columns} pixels, more than {MAX_PIXELS}; "
            "the header is damaged, or the file must be cut into smaller frames"
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


def check_finite(name: str, array: np.ndarray) -> None:
    """Refuse NaN and infinity.

    Raises
    ------
    InputError
        A float pixel is not finite; the first one is named.
    """
    if array.dtype.kind != "f":
        return
    with np.errstate(over="ignore", invalid="ignore"):
        if np.isfinite(array.sum()):  # one cheap pass; a finite sum has finite terms
            return
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        row, column = bad[0]
        raise InputError(
            f"{name}: {len(bad)} pixels are NaN or infinite, the first at row {row}, column "
            f"{column}; store the raw counts, without masked pixels"
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
        NaN or infinite pixels, all pixels zero, or all pixels equal.
    """
    check_finite(name, array)
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
