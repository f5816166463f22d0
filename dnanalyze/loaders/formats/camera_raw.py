"""Camera raw and DNG through LibRaw: visible area, masked strip, levels and colour filter."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import rawpy
import tifffile

from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.checks import MIN_COLUMNS, MIN_ROWS, check_length, check_memory, check_shape
from dnanalyze.loaders.config import Config
from dnanalyze.loaders.headers import from_header
from dnanalyze.loaders.recording import Metadata, Recording, one_line, shifted_cfa
from dnanalyze.robust import robust_deviation

# The rim of a masked area sees stray light and the start of the readout.
_GUARD_ROWS, _GUARD_COLUMNS = 16, 4
_NOTES = {  # by tag of the image
    50712: "The files expand their codes by a table (LinearizationTable): the steps between codes "
    "differ, and so does the noise of rounding.",
}
_FLOATS = (
    "The files hold floating-point pixels, which LibRaw scales and rounds to integers: one DN here "
    "is another unit; save integers, or give the frames as TIFF or FITS."
)
_BLACK = (50713, 50714, 50715, 50716)  # BlackLevelRepeatDim, BlackLevel, BlackLevelDeltaH, DeltaV
ROUNDED = 1.5  # DN, within which a level is that of the masked pixels
_MAX_PAGES = 100  # previews and the image itself; cameras write three or four


def read(path: Path, name: str, config: Config, previous: Recording | None) -> Recording:
    """The header of a camera raw file.

    LibRaw knows the levels only after it has decoded the pixels, so that is done for the first
    file of a camera and wherever the ISO speed or the stated black level changes; the others take
    them from the one before.
    """
    metadata, stated, told = _exif(path, name)
    with open_raw(path) as raw:
        sizes = raw.sizes
        shape = sizes.raw_height, sizes.raw_width
        check_shape(name, shape)
        check_memory(name, 6 * shape[0] * shape[1])
        same = previous is not None and (previous.format, previous.shape) == (_kind(path), shape)
        if same and previous is not None:
            before = getattr(previous.read, "stated", None)
            iso = metadata.gain if metadata is not None else None
            same = before == stated and iso == previous.frames[0].gain
        if metadata is None or not same:
            _unpack(raw, name)
            metadata = (metadata or Metadata()).or_else(_shot(raw))
        if same and previous is not None:
            return _like(previous, RawImage(path, stated), metadata)
        if raw.raw_type != rawpy.RawType.Flat:
            raise InputError(f"{name}: holds full-colour pixels, not one value a pixel")
        active = Window(
            sizes.top_margin,
            sizes.top_margin + sizes.height,
            sizes.left_margin,
            sizes.left_margin + sizes.width,
        )
        masked = _masked(active, shape)
        black = _black(raw, masked)
        notes = told
        if masked is not None:
            notes += (
                "The files hold a masked (optical black) strip of "
                f"{masked.shape[0]} x {masked.shape[1]} pixels; region 'masked' loads it.",
            )
        return Recording(
            _kind(path),
            shape,
            np.dtype(np.uint16),
            RawImage(path, stated),
            (metadata,),
            active=active,
            masked=masked,
            cfa=_colour_filter(raw, active),
            bits=math.ceil(math.log2(raw.white_level + 1)) if raw.white_level else None,
            black_level=black,
            white_level=float(raw.white_level) if raw.white_level else None,
            notes=notes,
            lit=masked is not None and _lit(raw, active, masked),
        )


@dataclass(frozen=True)
class RawImage:
    """Decodes the whole readout; compressed raw has no partial reading.

    ``stated`` is what the tags of the file say of its black level.
    """

    path: Path
    stated: str = ""

    def __call__(self, index: int, window: Window) -> np.ndarray:
        """Pixels of ``window`` of the readout."""
        with open_raw(self.path) as raw:
            return np.array(raw.raw_image[window.slices])


def open_raw(path: Path) -> Any:
    """The file opened by LibRaw, as a context manager.

    Raises
    ------
    InputError
        LibRaw does not know it.
    """
    try:
        return rawpy.imread(str(path))
    except rawpy.LibRawError as error:
        raise InputError(
            f"{path.name}: LibRaw cannot open it ({one_line(error)}); it is damaged, truncated or "
            f"of an unknown camera: copy it again, or convert it to {_other(path)}"
        ) from error


def _other(path: Path) -> str:
    return "16-bit TIFF" if path.suffix.lower() == ".dng" else "DNG"


def _unpack(raw: Any, name: str) -> None:
    try:
        raw.unpack()
    except rawpy.LibRawError as error:
        raise InputError(
            f"{name}: LibRaw cannot decode it ({one_line(error)}); copy the file again or "
            "leave it out"
        ) from error


def _kind(path: Path) -> str:
    return "DNG" if path.suffix.lower() == ".dng" else f"camera raw {path.suffix[1:].upper()}"


def _like(previous: Recording, read: RawImage, metadata: Metadata) -> Recording:
    return replace(previous, read=read, frames=(metadata,))


def _masked(active: Window, shape: tuple[int, int]) -> Window | None:
    """The left masked strip without its rim, as tall as the readout; None where there is none."""
    left, right = _GUARD_COLUMNS, active.left - _GUARD_COLUMNS
    top, bottom = _GUARD_ROWS, shape[0] - _GUARD_ROWS
    if right - left < MIN_COLUMNS or bottom - top < MIN_ROWS:
        return None
    return Window(top, bottom, left, right)


def _black(raw: Any, masked: Window | None) -> float | None:
    """The black level that LibRaw states, DN, the mean over the colours.

    Where it is that of the masked pixels, which LibRaw cuts to whole DN, it is measured there.
    """
    stated = [float(b) for b in raw.black_level_per_channel]
    if not stated:
        return None
    level = sum(stated) / len(stated)
    if masked is None:
        return level
    strip = raw.raw_image[masked.slices]
    middle, spread = float(np.median(strip)), max(1.0, robust_deviation(strip))
    own = float(np.clip(strip, middle - 4 * spread, middle + 4 * spread).mean())
    return own if abs(own - level) < ROUNDED else level


def _lit(raw: Any, active: Window, masked: Window) -> bool:
    """Whether the active area lies far above the masked strip, which shares all but the light.

    Ten robust standard deviations of the strip and one percent of the range: more than
    differences of dark current and offset between the two make.
    """
    dark = raw.raw_image[masked.slices][::4]
    level = float(np.median(dark))
    spread = robust_deviation(dark, level)
    rise = float(np.median(raw.raw_image[active.slices][::16, ::3])) - level
    return rise > max(10.0 * spread, 0.01 * (raw.white_level - level))


def _colour_filter(raw: Any, active: Window) -> Any:
    """The filter at the top left of the readout; None for a monochrome sensor."""
    pattern = raw.raw_pattern
    if pattern is None or raw.num_colors < 3:
        return None
    letters = raw.color_desc.decode("ascii", "replace")
    rows, columns = pattern.shape
    visible = tuple(
        tuple(letters[raw.raw_color(active.top + r, active.left + c)] for c in range(columns))
        for r in range(rows)
    )
    return shifted_cfa(visible, -active.top, -active.left)


def _exif(path: Path, name: str) -> tuple[Metadata | None, str, tuple[str, ...]]:
    """Of files built like a TIFF (DNG, CR2, NEF, ARW) exposure, ISO, black level tags and notes.

    None for other files.

    Raises
    ------
    InputError
        The file ends before the pixels that it declares.
    """
    air = "AmbientTemperature"
    names = {k: k for k in ("ExposureTime", "ISOSpeedRatings", air)} | {"Temperature": air}
    header: dict[str, Any] = {}
    needed, stated = 0, ""
    told: dict[str, None] = {}
    try:
        with tifffile.TiffFile(path) as tif:
            first: Any = tif.pages[0]
            for tag in first.tags.values():
                values = tag.value if tag.name == "ExifTag" else {tag.name: tag.value}
                if isinstance(values, dict):
                    header.update({names[k]: v for k, v in values.items() if k in names})
            pages: list[Any] = [
                *islice(tif.pages, _MAX_PAGES),
                *islice(first.pages or (), _MAX_PAGES),
            ]
            for page in pages:
                stated += "".join(str(page.tags[t].value) for t in _BLACK if t in page.tags)
                told |= dict.fromkeys(text for tag, text in _NOTES.items() if tag in page.tags)
                if page.dtype is not None and page.dtype.kind == "f":
                    told[_FLOATS] = None
                runs = zip(page.dataoffsets, page.databytecounts, strict=False)
                needed = max([needed, *(start + length for start, length in runs)])
    except Exception:  # no TIFF, or one that tifffile does not know: LibRaw reads it
        return None, "", ()
    check_length(name, needed, path.stat().st_size)
    return from_header(header) if header else None, stated, tuple(told)


def _shot(raw: Any) -> Metadata:
    """Exposure and ISO as LibRaw reads them."""
    other = getattr(raw, "other", None)
    if other is None:
        return Metadata()
    exposure, iso = float(other.shutter_speed), float(other.iso_speed)
    return Metadata(exposure_s=exposure or None, gain=iso or None)
