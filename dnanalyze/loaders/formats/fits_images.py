"""Which images of a FITS file hold frames, of several chips or of one in a series, and masks."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from dnanalyze.errors import InputError
from dnanalyze.loaders.formats.fits_units import Unit

_MAX_IMAGES = 256  # the largest mosaic camera has 201 chips
_MAX_CARDS = 100_000  # over all images, the inherited ones counted for each; about 1 s
# What pipelines put beside an image; of the first kind every pixel that is not 0 is bad.
_MASKS = re.compile(
    r"\w*DQ|[A-Z]*_?MASK|BPM|BAD_?PIX\w*|(?:DATA_?)?QUAL(?:ITY)?|FLAGS?", re.IGNORECASE
)
_BESIDE = re.compile(
    r"ERR(?:OR)?|UNC(?:ERT\w*)?|VAR(?:IANCE)?|IVAR|WHT|WEIGHT|SAMP|TIME|THUMB(?:NAIL)?|PREVIEW",
    re.IGNORECASE,
)
_NAMES = (
    "EXTNAME",
    "CCDNAME",
    "CHIPNAME",
    "CHIPID",
    "CCDNUM",
    "CHIP",
    "AMPNAME",
    "AMPID",
    "IMAGEID",
)
_TIMES = (
    "DATE-OBS", "DATE-BEG", "TIME-OBS", "UTC", "UT", "MJD-OBS", "MJD", "JD", "TIMESTMP", "FRAMENO",
    "FRAME",
)  # fmt: skip
_OWN = re.compile(
    r"SIMPLE|XTENSION|BITPIX|NAXIS\d*|PCOUNT|GCOUNT|GROUPS|EXTEND|BSCALE|BZERO|BLANK|EXT(?:NAME"
    r"|VER|LEVEL)|CHECKSUM|DATASUM|INHERIT|END"
)


@dataclass(frozen=True)
class Image:
    """One image that holds frames.

    Parameters
    ----------
    unit : Unit
        Its own header and place.
    values, comments : dict
        Key words, those of the primary header included where it does not say otherwise.
    channel : str
        Its chip, or "".
    """

    unit: Unit
    values: dict[str, Any]
    comments: dict[str, str]
    channel: str


def images(units: Sequence[Unit], name: str, notes: list[str]) -> tuple[list[Image], list[Image]]:
    """The images of a file that hold frames of one shape, and its masks of their shape.

    Parameters
    ----------
    units : sequence of Unit
        All of the file.
    name : str
        For messages.
    notes : list of str
        Takes what is left out, and what the several images are taken for.

    Returns
    -------
    frames, masks : list of Image

    Raises
    ------
    InputError
        No image, or too many.
    """
    found = [u for u in units if u.is_image or u.is_compressed]
    masks = [u for u in found if _MASKS.fullmatch(_text(u, "EXTNAME"))]
    beside = [u for u in found if _BESIDE.fullmatch(_text(u, "EXTNAME"))]
    found = [u for u in found if u not in beside and u not in masks]
    if not found:
        raise InputError(f"{name}: holds no image; give files with one image or cube each")
    if len(found) > _MAX_IMAGES:
        raise InputError(f"{name}: holds {len(found)} images, more than {_MAX_IMAGES}; split it")
    cards = sum(len(u.header) for u in found) + len(found) * len(units[0].header)
    if len(found) > 1 and cards > _MAX_CARDS:
        raise InputError(f"{name}: its headers hold {cards} cards; damaged: copy it again")
    shape = Counter(_shape(u) for u in found).most_common(1)[0][0]
    beside += [u for u in found if _shape(u) != shape]
    beside += [u for u in masks if _shape(u) != shape[:2]]
    masks = [u for u in masks if _shape(u) == shape[:2]][:_MAX_IMAGES]
    found = [u for u in found if _shape(u) == shape]
    if beside:
        notes.append(
            "Images that hold no frames of this sensor are left out: "
            f"{', '.join(_label(u) for u in beside)[:120]}."
        )
    channels = _channels(found, notes)
    frames = [_image(units[0], u, c) for u, c in zip(found, channels, strict=True)]
    return frames, [_image(u, u, "") for u in masks]


def _channels(found: list[Unit], notes: list[str]) -> list[str]:
    """The chip of each image; no chips in a single image or a series of one chip."""
    if len(found) == 1:
        return [""]
    labels = [_label(u) for u in found]
    if len(set(labels)) < len(labels):
        labels = [f"{label} {k}" for k, label in enumerate(labels, 1)]
    shown = f"Each file holds {len(found)} images"
    for key in _TIMES:
        times = {_text(u, key) for u in found}
        if len(times) == len(found) and "" not in times and not _named_apart(found):
            notes.append(f"{shown}, taken as successive frames: they differ in {key}.")
            return [""] * len(found)
    notes.append(f"{shown}, taken as channels by name: {', '.join(labels)[:120]}.")
    return labels


def _named_apart(found: list[Unit]) -> bool:
    """Whether a name of chip or extension tells the images apart."""
    return any(len({_text(u, key) for u in found} - {""}) == len(found) for key in _NAMES)


def _label(unit: Unit) -> str:
    """The first of its names, or its number."""
    named = next(filter(None, (_text(unit, key) for key in _NAMES)), "")
    return named or f"image {unit.number}"


def _shape(unit: Unit) -> tuple[int, ...]:
    tiled = "Z" if unit.is_compressed else ""
    axes = unit.header.get(f"{tiled}NAXIS", 0)
    return tuple(unit.header.get(f"{tiled}NAXIS{k}", 0) for k in range(1, int(axes) + 1))


def _text(unit: Unit, key: str) -> str:
    value = unit.header.get(key)
    return "" if value is None else str(value).strip()[:40]


def _image(primary: Unit, unit: Unit, channel: str) -> Image:
    """Its key words and the primary header's, unless it says INHERIT = F."""
    from_primary = unit is not primary and unit.header.get("INHERIT", True) is not False
    cards = [
        *(c for c in primary.header.cards if from_primary and not _OWN.fullmatch(c.keyword)),
        *unit.header.cards,
    ]
    kept = [c for c in cards if c.keyword not in ("", "COMMENT", "HISTORY")]
    return Image(
        unit, {c.keyword: c.value for c in kept}, {c.keyword: c.comment for c in kept}, channel
    )
