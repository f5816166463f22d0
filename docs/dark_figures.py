"""A figure of the site in the colours of its dark scheme."""

from __future__ import annotations

from typing import Any

from matplotlib.colors import to_hex

from dnanalyze.report.figures.palette import TONES

PAPER = "#1e2129"  # of the page, as the theme has it
DARK = dict(TONES.values()) | {TONES["paper"][0]: PAPER}
PARTS = "color", "facecolor", "edgecolor", "markerfacecolor", "markeredgecolor"


def darken(figure: Any) -> None:
    """Turn every colour of the palette to its tone on dark paper; images stay as they are."""
    for artist in figure.findobj():
        for part in PARTS:
            read, write = (getattr(artist, f"{do}_{part}", None) for do in ("get", "set"))
            if read is None or write is None:
                continue
            turned = DARK.get(_hex(read()))
            if turned is not None:
                write(turned)


def _hex(colour: Any) -> str:
    """As #rrggbb; nothing for several colours, or where there is none to see."""
    try:
        rgba = to_hex(colour, keep_alpha=True)
    except (ValueError, TypeError):
        return ""
    return rgba[:7] if rgba[7:] != "00" else ""
