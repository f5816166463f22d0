"""What acquisition programs write into TIFF: Micro-Manager's JSON, OME-XML, ImageJ's lines."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree

from dnanalyze.loaders.headers import from_header
from dnanalyze.loaders.program_text import flat_properties
from dnanalyze.loaders.recording import Doubt, Metadata
from dnanalyze.loaders.units import SECONDS, read_number

_MOST_XML = 8 << 20  # characters; a plane takes about 150
_MOST_JSON = 1 << 20


def micro_manager(page: Any) -> Metadata:
    """The metadata that Micro-Manager keeps in tag 51123 of each page."""
    tag = page.tags.get(51123)
    if tag is None:
        return Metadata()
    plain = tag.value
    if isinstance(plain, (str, bytes)) and len(plain) <= _MOST_JSON:
        try:
            plain = json.loads(plain)
        except (ValueError, RecursionError):
            return Metadata()
    if not isinstance(plain, dict):
        return Metadata()
    return from_header(flat_properties(plain)).said_by("Micro-Manager")


def ome(text: str, pages: int) -> list[Metadata]:
    """The metadata of each page that OME-XML states; empty where it is none.

    Several colour channels are channels; several exposures belong to the planes in their order.
    """
    if not 0 < len(text) <= _MOST_XML or "<!" in text.replace("<!--", ""):  # no entities
        return []
    try:
        root = ElementTree.fromstring(text.encode())
    except (ElementTree.ParseError, ValueError):
        return []
    pixels = next(_all(root, "Pixels"), None)
    if pixels is None:
        return []
    planes = [_plane(p) for p in _all(pixels, "Plane")]
    channels = _channels(pixels, pages)
    if len(planes) != pages:  # pages in another order, or of several images
        times = {p.exposure_s for p in planes}
        shared = planes[0] if len(times) == 1 and planes else Metadata()
        if len(times) > 1:
            said = "OME-XML states several exposures, and not one for each page; taken as unknown"
            shared = Metadata(doubts=(Doubt("exposure_s", "ome", said),))
        planes = [shared] * pages
    return [
        plane.in_channel(channel, "OME-XML") if channel else plane
        for plane, channel in zip(planes, channels, strict=True)
    ]


def imagej(text: str, pages: int) -> list[Metadata]:
    """The channels of an ImageJ stack, which come one after another; empty where there is one."""
    match = re.search(r"^channels=(\d{1,6})\s*$", text, re.MULTILINE)
    count = int(match[1]) if match and text.startswith("ImageJ") else 1
    if count < 2 or pages % count:
        return []
    said = [Metadata(channel=f"channel {c}").of("ImageJ") for c in range(1, count + 1)]
    return said * (pages // count)


def _plane(plane: ElementTree.Element) -> Metadata:
    value = read_number(plane.get("ExposureTime"))
    if value is None:
        return Metadata()
    unit = plane.get("ExposureTimeUnit", "s").strip().lower()
    doubts: tuple[Doubt, ...] = ()
    if unit not in SECONDS:
        text = f"ExposureTimeUnit = {unit[:20]!r} is no unit; taken as s"
        doubts = (Doubt("exposure_s", "ome unit", text),)
    shown = f"{value.value:g} {unit}"[:40]
    return Metadata(
        exposure_s=value.value * SECONDS.get(unit, 1.0),
        taken={"exposure_s": ("OME-XML ExposureTime", shown)},
        doubts=doubts,
    )


def _channels(pixels: ElementTree.Element, pages: int) -> list[str]:
    """The channel of each page by the order of the dimensions; "" where there is one."""
    sizes = {}
    for axis in "ZCT":
        text = pixels.get(f"Size{axis}", "1")
        sizes[axis] = int(text) if re.fullmatch(r"[1-9]\d{0,6}", text) else 1
    order = pixels.get("DimensionOrder", "XYZCT")[2:5]
    count = sizes["C"]
    if count < 2 or sorted(order) != ["C", "T", "Z"] or sizes["Z"] * sizes["T"] * count != pages:
        return [""] * pages
    every = 1
    for axis in order[: order.index("C")]:
        every *= sizes[axis]
    names = [c.get("Name") or "" for c in _all(pixels, "Channel")]
    if len(set(names)) != count or "" in names:
        names = [f"channel {c}" for c in range(1, count + 1)]
    return [names[k // every % count][:40] for k in range(pages)]


def _all(element: ElementTree.Element, name: str) -> Iterator[ElementTree.Element]:
    """All elements of this name below, whatever their name space."""
    return (e for e in element.iter() if str(e.tag).rpartition("}")[2] == name)
