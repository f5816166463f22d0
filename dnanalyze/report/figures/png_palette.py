"""Images of a figure with a palette instead of four bytes a pixel: the same colours, lighter."""

from __future__ import annotations

import io
import re
from base64 import b64decode, b64encode

_IMAGE = re.compile(r"data:image/png;base64,([A-Za-z0-9+/=\s]+)")
_COLOURS = 256


def lighter(svg: str) -> str:
    """An SVG whose embedded PNG images of at most 256 opaque colours have a palette.

    Parameters
    ----------
    svg : str
        As matplotlib writes it.
    """
    return _IMAGE.sub(lambda found: "data:image/png;base64," + _smaller(found[1]), svg)


def _smaller(text: str) -> str:
    from PIL import Image

    data = b64decode("".join(text.split()))
    image = Image.open(io.BytesIO(data)).convert("RGBA")
    colours = image.getcolors(_COLOURS)
    if colours is None or any(colour[3] != 255 for _, colour in colours):  # type: ignore[index]
        return "".join(text.split())
    room = io.BytesIO()
    made = image.convert("RGB").convert("P", palette=Image.Palette.ADAPTIVE, colors=len(colours))
    made.save(room, format="png", optimize=True)
    return b64encode(room.getvalue()).decode("ascii")
