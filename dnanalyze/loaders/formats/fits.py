"""FITS: images and cubes, with the key words of CCD cameras; packed by gzip or in tiles.

Unsigned integers stored with BZERO (FITS standard 4.0, section 5.2.5) stay unsigned integers;
any other BSCALE or BZERO makes float32.
"""

from __future__ import annotations

import gzip
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from astropy.io import fits

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import (
    check_count,
    check_length,
    check_memory,
    check_shape,
    check_stored,
)
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.formats.fits_packed import GzipPixels, TilePixels, check_tiles
from dnanalyze.loaders.formats.fits_units import Unit, units, whole
from dnanalyze.loaders.headers import (
    as_bias,
    bayer_pattern,
    electrons_per_dn,
    from_header,
    image_type,
)
from dnanalyze.loaders.plain import PlainPixels
from dnanalyze.loaders.recording import Metadata, Recording, shifted_cfa

_DTYPES = {8: ">u1", 16: ">i2", 32: ">i4", 64: ">i8", -32: ">f4", -64: ">f8"}


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The header of the first image of a FITS file."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # astropy warns of what is checked and worded here
        return _read(path, name)


def _read(path: Path, name: str) -> Recording:
    packed = path.suffix.lower() == ".gz"
    with gzip.open(path) if packed else path.open("rb") as file:
        unit = _first_image(file, name, packed)
    header = unit.header
    tiled = "Z" if unit.is_compressed else ""
    axes = [whole(header, f"{tiled}NAXIS{k}") for k in range(whole(header, f"{tiled}NAXIS"), 0, -1)]
    if not 2 <= len(axes) <= 4 or (len(axes) > 2 and axes[-3] == 3 and "COLORTYP" in header):
        raise InputError(f"{name}: has {axes[:9]} pixels; give an image or a cube of frames")
    shape = axes[-2], axes[-1]
    check_shape(name, shape)
    count = int(np.prod(axes[:-2], dtype=object)) if len(axes) > 2 else 1
    check_count(name, count)
    stored = _stored(header, f"{tiled}BITPIX", name)
    frame_bytes = shape[0] * shape[1] * stored.itemsize
    end = unit.offset + (unit.size if tiled else count * frame_bytes)
    scale, zero = float(header.get("BSCALE", 1.0)), float(header.get("BZERO", 0.0))
    unsigned = stored.kind == "i" and scale == 1.0 and zero == 2.0 ** (8 * stored.itemsize - 1)
    plain = PlainPixels(
        path, range(unit.offset, unit.offset + count * frame_bytes, frame_bytes), shape,
        stored.str, unsigned,
    )  # fmt: skip
    as_integers = unsigned or (scale == 1.0 and zero == 0.0 and "BLANK" not in header)
    dtype = np.dtype(stored.newbyteorder("=").str.replace("i", "u") if unsigned else stored)
    present = path.stat().st_size
    pixels: Callable[[int, Window], np.ndarray] = plain
    if tiled or packed:
        check_memory(name, 3 * frame_bytes)
        check_stored(name, present, count * shape[0] * shape[1], count * frame_bytes)
    if tiled:
        if packed:
            raise InputError(f"{name}: is compressed twice; unpack it with gunzip first")
        check_length(name, end, present)
        check_tiles(header, axes, name)
        pixels = TilePixels(path, unit.number, len(axes), tuple(axes[:-2]))
    elif packed:
        pixels = GzipPixels(plain)
    else:
        check_length(name, end, present)
    if not as_integers:
        dtype = np.dtype(np.float32)
        if not tiled:  # tiles come scaled
            blank = header.get("BLANK") if stored.kind in "iu" else None
            pixels = Scaled(pixels, scale, zero, blank)
    notes: list[str] = []
    active, masked = _sections(header, shape, notes)
    return Recording(
        "FITS",
        shape,
        dtype.newbyteorder("="),
        pixels,
        (_metadata(header),) * count,
        active=active,
        masked=masked,
        cfa=_colour_filter(header),
        pixel_pitch_um=_positive(header.get("XPIXSZ")),
        system_gain_dn_e=_inverse(electrons_per_dn(*_cards(header))),
        notes=tuple(notes),
        left_out=_left_out(header),
    )


def _first_image(file: Any, name: str, packed: bool) -> Unit:
    for unit in units(file, name, packed):
        if unit.is_image or unit.is_compressed:
            return unit
    raise InputError(f"{name}: holds no image; give files with one image or cube each")


def _stored(header: fits.Header, key: str, name: str) -> np.dtype:
    bits = whole(header, key)
    if bits not in _DTYPES:
        raise InputError(
            f"{name}: {key} = {bits}; valid: {', '.join(map(str, _DTYPES))}: damaged header"
        )
    return np.dtype(_DTYPES[bits])


@dataclass(frozen=True)
class Scaled:
    """``BZERO + BSCALE * stored`` in float32; stored ``BLANK`` becomes NaN."""

    plain: Callable[[int, Window], np.ndarray]
    scale: float
    zero: float
    blank: int | None
    partial: ClassVar[bool] = True

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of plane ``index``."""
        stored = self.plain(index, window)
        array = (stored * self.scale + self.zero).astype(np.float32)
        if self.blank is not None:
            array[stored == self.blank] = np.nan
        return array


def _metadata(header: fits.Header) -> Metadata:
    metadata = from_header(*_cards(header))
    return as_bias(metadata) if image_type(header) == "bias" else metadata


def _cards(header: fits.Header) -> tuple[dict[str, Any], dict[str, str]]:
    """Values and comments by key word."""
    cards = [c for c in header.cards if c.keyword not in ("", "COMMENT", "HISTORY")]
    return {c.keyword: c.value for c in cards}, {c.keyword: c.comment for c in cards}


def _left_out(header: fits.Header) -> str:
    kind = image_type(header)
    return f"its header says {kind} frame" if kind in ("light", "flat") else ""


def _section(text: Any, shape: tuple[int, int]) -> Window | None:
    """``[x1:x2,y1:y2]``, from 1 and inclusive, to a window; None where it does not fit."""
    match = re.fullmatch(r"\s*\[(\d+):(\d+),(\d+):(\d+)\]\s*", str(text))
    if match is None:
        return None
    x1, x2, y1, y2 = map(int, match.groups())
    fits_in = 1 <= x1 <= x2 <= shape[1] and 1 <= y1 <= y2 <= shape[0]
    return Window(y1 - 1, y2, x1 - 1, x2) if fits_in else None


def _sections(
    header: fits.Header, shape: tuple[int, int], notes: list[str]
) -> tuple[Window | None, Window | None]:
    """Active area from DATASEC or TRIMSEC; overscan from BIASSEC, or what lies beside the data."""
    active = _section(header.get("DATASEC"), shape) or _section(header.get("TRIMSEC"), shape)
    bias = _section(header.get("BIASSEC"), shape)
    if active == Window.whole(shape):
        active = None
    if active is None:
        return None, bias
    if bias is not None and _disjoint(active, bias):
        return active, bias
    beside = _widest_margin(active, shape)
    if bias is not None:
        notes.append(
            f"BIASSEC {header['BIASSEC']} overlaps DATASEC {header['DATASEC']}; the overscan is "
            f"taken to be rows {beside.top} to {beside.bottom - 1}, columns {beside.left} to "
            f"{beside.right - 1} (from 0), which DATASEC leaves out."
        )
    return active, beside


def _disjoint(a: Window, b: Window) -> bool:
    return a.right <= b.left or b.right <= a.left or a.bottom <= b.top or b.bottom <= a.top


def _widest_margin(active: Window, shape: tuple[int, int]) -> Window:
    rows, columns = shape
    margins = (
        Window(active.top, active.bottom, 0, active.left),
        Window(active.top, active.bottom, active.right, columns),
        Window(0, active.top, active.left, active.right),
        Window(active.bottom, rows, active.left, active.right),
    )
    return max(margins, key=lambda m: m.shape[0] * m.shape[1])


def _colour_filter(header: fits.Header) -> Any:
    pattern = bayer_pattern(header.get("BAYERPAT", header.get("COLORTYP", "")))
    try:
        dx, dy = int(header.get("XBAYROFF", 0)), int(header.get("YBAYROFF", 0))
    except (TypeError, ValueError):
        dx = dy = 0
    return shifted_cfa(pattern, dy, dx)


def _inverse(value: float | None) -> float | None:
    """EGAIN is in e-/DN, the system gain in DN/e-."""
    return None if value is None else 1.0 / value


def _positive(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) and 0 < value < 1e6 else None
