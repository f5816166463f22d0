"""Headers of a FITS file, one after another, read without trust: FITS standard 4.0, sections 3, 4.

A library that follows a header literally makes as many axes or columns as a damaged one declares;
so each header is bounded and checked here before anything else sees it.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import IO, Any

from astropy.io import fits

from dnanalyze.errors import InputError

BLOCK = 2880  # bytes
_MAX_BLOCKS = 500  # of a header: 18,000 cards
_MAX_UNITS = 1000
_MAX_AXES = _MAX_COLUMNS = 999  # FITS standard 4.0, sections 4.4.1.1 and 7.2.1
_MAX_SKIPPED = 1 << 28  # bytes of compressed data that are unpacked to reach the image


@dataclass(frozen=True)
class Unit:
    """One header and data unit.

    Parameters
    ----------
    number : int
        From 0, the primary one.
    header : astropy.io.fits.Header
    offset, size : int
        Its data, bytes from the start of the file (once unpacked).
    """

    number: int
    header: fits.Header
    offset: int
    size: int

    @property
    def axes(self) -> list[int]:
        """Lengths of the axes, slowest first."""
        return [whole(self.header, f"NAXIS{k}") for k in range(whole(self.header, "NAXIS"), 0, -1)]

    @property
    def is_image(self) -> bool:
        """Whether it holds an image of two axes or more."""
        kind = str(self.header.get("XTENSION", "IMAGE")).strip()
        return kind == "IMAGE" and len(self.axes) >= 2

    @property
    def is_compressed(self) -> bool:
        """Whether it is a table that holds the tiles of a compressed image (section 10)."""
        kind = str(self.header.get("XTENSION", "")).strip()
        return kind == "BINTABLE" and self.header.get("ZIMAGE") is True


def units(file: IO[bytes], name: str, packed: bool) -> Iterator[Unit]:
    """The units of a file, headers alone.

    Parameters
    ----------
    file : binary file
        Its content, unpacked where it was packed.
    name : str
        For messages.
    packed : bool
        Whether to skip data means to unpack them.

    Raises
    ------
    InputError
        No FITS, a header without end or with values that cannot be.
    """
    offset = 0
    for number in range(_MAX_UNITS):
        if packed and offset > _MAX_SKIPPED:
            break
        try:
            file.seek(offset)
            text = _text(file, name, number)
        except EOFError:  # a gzip stream that ends within the data; who reads them refuses it
            if number:
                return
            raise
        if text is None:
            return
        header = _parsed(text, name)
        offset += len(text)
        unit = Unit(number, header, offset, _size(header, name))
        yield unit
        offset += math.ceil(unit.size / BLOCK) * BLOCK


def whole(header: fits.Header, key: str, default: int = 0) -> int:
    """A card that is a whole number.

    Raises
    ------
    ValueError
        It is something else.
    """
    value = header.get(key, default)
    if not isinstance(value, int) or isinstance(value, bool):
        raise ValueError(f"{key} = {str(value)[:40]!r} is no whole number")
    return value


def _text(file: IO[bytes], name: str, number: int) -> str | None:
    """One header's text; None where the file has ended."""
    blocks: list[bytes] = []
    while len(blocks) < _MAX_BLOCKS:
        block = file.read(BLOCK)
        if not blocks:
            if number and not block.startswith(b"XTENSION"):
                return None  # the end, or special records (section 3.5)
            if not number and not block.startswith(b"SIMPLE  ="):
                raise InputError(f"{name}: is no FITS file (no SIMPLE card); correct its suffix")
        if len(block) < BLOCK:
            raise InputError(f"{name}: truncated within its header; copy the file again")
        blocks.append(block)
        if any(block[k : k + 8] == b"END     " for k in range(0, BLOCK, 80)):
            printable = bytes(c if 32 <= c < 127 else 63 for c in b"".join(blocks))
            return printable.decode("ascii")
    raise InputError(f"{name}: its header has no END in {_MAX_BLOCKS} blocks; damaged")


def _parsed(text: str, name: str) -> fits.Header:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # astropy warns of what is checked and worded here
        header = fits.Header.fromstring(text)
        limits = {"NAXIS": _MAX_AXES, "TFIELDS": _MAX_COLUMNS, "ZNAXIS": _MAX_AXES}
        for key, most in limits.items():
            value = whole(header, key)
            if not 0 <= value <= most:
                raise InputError(f"{name}: {key} = {value}; valid: 0 to {most}: damaged header")
    return header


def _size(header: fits.Header, name: str) -> int:
    """Bytes of the data (equation 2 of section 4.4.1.1; random groups hold no frames)."""
    lengths: list[Any] = [whole(header, f"NAXIS{k + 1}") for k in range(whole(header, "NAXIS"))]
    extra, groups = whole(header, "PCOUNT"), whole(header, "GCOUNT", 1)
    if min([extra, groups, *lengths]) < 0:
        raise InputError(f"{name}: a length in its header is negative; damaged: copy it again")
    if not lengths:
        return 0
    return abs(whole(header, "BITPIX")) // 8 * groups * (extra + math.prod(lengths))
