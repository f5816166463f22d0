"""A matplotlib figure as an SVG that stands in a page: small, its text and colours the page's."""

from __future__ import annotations

import base64
import io
import re
from typing import Any

from dnanalyze.report.figures.palette import turning

# what matplotlib states in a style sheet, which would speak for the whole page, and the page's font
ROOT = (
    "font-family:'Helvetica Neue','Liberation Sans',Arial,sans-serif;"
    "stroke-linejoin:round;stroke-linecap:butt"
)


def svg_of(fig: Any) -> str:
    """The figure as SVG text. It is laid out once: a canvas does so before and while it draws."""
    layout = fig.get_layout_engine()
    if layout is not None:
        layout.execute(fig)
        fig.set_layout_engine(None)
    stream = io.StringIO()
    fig.savefig(stream, format="svg", metadata={"Date": None, "Creator": None}, dpi=150)
    text = stream.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>|<!--.*?-->|<style.*?</style>", "", text, flags=re.S)
    text = text.replace("<svg ", f'<svg style="{ROOT}" ', 1)
    text = text.replace("font-family: 'DejaVu Sans'; ", "").replace(
        "; font-family: 'DejaVu Sans'", ""
    )
    text = re.sub(r' transform="rotate\(-?0 [^"]*"', "", text)
    text = re.sub(r'(?<= d=")[^"]+', lambda m: _path(m[0]), text)
    text = re.sub(r'(?<= [xy]=")[^"]+', lambda m: _path(m[0]), text)
    text = re.sub(
        r"(?<=style=\")[^\"]+", lambda m: turning(m[0].replace("; ", ";").replace(": ", ":")), text
    )
    # only what is referred to needs a name
    used = set(re.findall(r'(?:url\(#|href="#)([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda m: m[0] if m[1] in used else "", text)
    text = re.sub(r"\n\s*", "\n", text)
    return re.sub(r"\n+(?=[</])", "", text)


def standing_alone(svg: str) -> str:
    """The drawing as a data URI for an image; its colours stay those of the light page."""
    return "data:image/svg+xml;base64," + base64.b64encode(svg.encode()).decode()


def _path(commands: str) -> str:
    """A path, or a place, to a hundredth of a point."""
    tidy = re.sub(r"(\.\d\d)\d+", r"\1", commands)
    return re.sub(r"\s+", " ", tidy).strip()


def named_apart(svg: str, prefix: str) -> str:
    """The names inside begin with ``prefix``, so that two pictures of a page never share one."""
    return re.sub(r'( id="|url\(#|href="#)', lambda m: m[1] + prefix, svg)
