"""FITS: images and cubes, with the key words of CCD cameras; packed by gzip or in tiles.

Unsigned integers stored with BZERO (FITS standard 4.0, section 5.2.5) stay unsigned integers;
any other BSCALE or BZERO makes float32.
"""

from __future__ import annotations

import gzip
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, ClassVar, cast

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
from dnanalyze.loaders.formats.fits_images import Image, images
from dnanalyze.loaders.formats.fits_packed import GzipPixels, TilePixels, check_tiles
from dnanalyze.loaders.formats.fits_sections import areas
from dnanalyze.loaders.formats.fits_units import units, whole
from dnanalyze.loaders.headers import (
    as_bias,
    bayer_pattern,
    electrons_per_dn,
    from_header,
    image_type,
)
from dnanalyze.loaders.layout import sign_doubt
from dnanalyze.loaders.masks import leaves_enough
from dnanalyze.loaders.plain import PlainPixels
from dnanalyze.loaders.recording import Area, Cfa, Metadata, Recording, shifted_cfa

_DTYPES = {8: ">u1", 16: ">i2", 32: ">i4", 64: ">i8", -32: ">f4", -64: ">f8"}


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The headers of the images of a FITS file: one, or several chips or frames."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # astropy warns of what is checked and worded here
        return _read(path, name, previous)


def _read(path: Path, name: str, previous: Recording | None) -> Recording:
    packed = path.suffix.lower() == ".gz"
    with gzip.open(path) if packed else path.open("rb") as file:
        found = list(units(cast(IO[bytes], file), name, packed))
    notes: list[str] = []
    frames, masks = images(found, name, notes)
    parts = [_part(path, name, image, packed, notes) for image in frames]
    first = parts[0]
    for part in parts:
        if part.dtype != first.dtype:
            raise InputError(
                f"{name}: {part.image.channel or 'an image'} is {part.dtype}, the first image "
                f"{first.dtype}; store images of one type"
            )
    places: list[tuple[int, int]] = []
    metadata: list[Metadata] = []
    own: list[Area] = []
    for number, part in enumerate(parts):
        known = _metadata(part.image)
        for amplifier, area in part.areas.items():
            channel = " ".join(filter(None, (part.image.channel, amplifier)))
            source = "amplifier section" if amplifier else "name of the image"
            said = known.in_channel(channel, source) if channel else known
            check_count(name, len(places) + part.count)
            places += [(number, k) for k in range(part.count)]
            metadata += [said] * part.count
            own += [area] * part.count
    values = first.image.values
    plain = first.pixels
    if previous is None and isinstance(plain, PlainPixels) and np.dtype(plain.dtype).str == ">i2":
        rows, columns = first.shape
        middle = Window(rows // 2 - min(8, rows // 2), rows // 2, 0, columns)
        notes += filter(None, [sign_doubt(plain(0, middle), plain.sign_flip)])
    return Recording(
        "FITS",
        first.shape,
        first.dtype.newbyteorder("="),
        first.pixels
        if len(places) == first.count
        else Parts(tuple(p.pixels for p in parts), tuple(places)),
        tuple(metadata),
        areas=tuple(own),
        cfa=_colour_filter(values, first.shape[0], notes),
        pixel_pitch_um=_positive(values.get("XPIXSZ")),
        system_gain_dn_e=_inverse(electrons_per_dn(values, first.image.comments)),
        mask=_mask([_part(path, name, m, packed, []) for m in masks], first.shape, notes),
        notes=tuple(dict.fromkeys(notes)),
        left_out=_left_out(values),
    )


@dataclass(frozen=True)
class _Part:
    """One image of a file."""

    image: Image
    shape: tuple[int, int]
    dtype: np.dtype
    pixels: Callable[[int, Window], np.ndarray]
    count: int
    areas: dict[str, Area]


@dataclass(frozen=True)
class Parts:
    """Frames of several images: ``places`` are (image, frame in it)."""

    parts: tuple[Callable[[int, Window], np.ndarray], ...]
    places: tuple[tuple[int, int], ...]

    @property
    def partial(self) -> bool:
        """Whether a window is read without the rest of the frame."""
        return all(getattr(p, "partial", False) for p in self.parts)

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of frame ``index``."""
        part, number = self.places[index]
        return self.parts[part](number, window)


def _mask(masks: Sequence[_Part], shape: tuple[int, int], notes: list[str]) -> np.ndarray | None:
    """Pixels that a mask of the file marks; a mask that leaves too few is told and not used."""
    marked = np.zeros(shape, bool)
    for mask in masks:
        own = mask.pixels(0, Window.whole(shape)) != 0  # NaN among them
        if leaves_enough(own):
            marked |= own
        else:
            notes.append(
                f"The mask {str(mask.image.values.get('EXTNAME')).strip()[:20]} marks "
                f"{100 * own.mean():.3g} % of the pixels, too many to leave out; not used. A mask "
                "of the bad pixels is taken with --mask."
            )
    return marked if marked.any() else None


def _part(path: Path, name: str, image: Image, packed: bool, notes: list[str]) -> _Part:
    unit, header = image.unit, image.unit.header
    tiled = "Z" if unit.is_compressed else ""
    axes = [whole(header, f"{tiled}NAXIS{k}") for k in range(whole(header, f"{tiled}NAXIS"), 0, -1)]
    if not 2 <= len(axes) <= 4:
        raise InputError(f"{name}: has {axes[:9]} pixels; give an image or a cube of frames")
    shape = axes[-2], axes[-1]
    check_shape(name, shape)
    _check_colours(image.values, axes, name, notes)
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
    return _Part(image, shape, dtype, pixels, count, areas(image.values, shape, notes))


def _check_colours(values: Mapping[str, Any], axes: list[int], name: str, notes: list[str]) -> None:
    """Refuse planes that the header calls colours; three planes without a word are doubted."""
    if len(axes) < 3 or axes[-3] not in (3, 4):
        return
    for key in (f"CTYPE{len(axes)}", "CTYPE3", "COLORTYP", "COLORSPC", "COLOR", "CSPACE"):
        text = str(values.get(key, "")).strip()
        if re.search(r"rgb|colou?r|red", text, re.IGNORECASE) or (text and key == "COLORTYP"):
            raise InputError(
                f"{name}: its {axes[-3]} planes are colours ({key} = {text[:20]!r}), interpolated "
                "from a mosaic; give the raw frames"
            )
    if axes[-3] == 3:
        notes.append(
            "The 3 planes of each file are taken as 3 frames; where they are colours, give the raw "
            "frames instead."
        )


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


def _metadata(image: Image) -> Metadata:
    metadata = from_header(image.values, image.comments)
    return as_bias(metadata) if image_type(image.values) == "bias" else metadata


def _left_out(values: Mapping[str, Any]) -> str:
    kind = image_type(values)
    return f"its header says {kind} frame" if kind in ("light", "flat") else ""


def _colour_filter(values: Mapping[str, Any], rows: int, notes: list[str]) -> Cfa | None:
    """The filter at the first stored pixel; BAYERPAT counts from the top of the sensor."""
    pattern = bayer_pattern(values.get("BAYERPAT", values.get("COLORTYP", "")))
    if pattern is None:
        return None
    try:
        dx, dy = int(values.get("XBAYROFF", 0)), int(values.get("YBAYROFF", 0))
    except (TypeError, ValueError):
        dx = dy = 0
    stored = shifted_cfa(pattern, dy, dx)
    if stored and str(values.get("ROWORDER", "")).strip().upper() == "BOTTOM-UP":
        stored = tuple(stored[(rows - 1 - r) % len(stored)] for r in range(len(stored)))
        notes.append(
            "ROWORDER is BOTTOM-UP: BAYERPAT is read from the top of the sensor, and the first "
            f"stored rows are {'/'.join(''.join(row) for row in stored)}."
        )
    return stored


def _inverse(value: float | None) -> float | None:
    """EGAIN is in e-/DN, the system gain in DN/e-."""
    return None if value is None else 1.0 / value


def _positive(value: Any) -> float | None:
    return float(value) if isinstance(value, (int, float)) and 0 < value < 1e6 else None
