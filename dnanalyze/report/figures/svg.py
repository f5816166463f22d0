"""A matplotlib figure as an SVG that stands in a page: small, its text and colours the page's."""

from __future__ import annotations

import io
import re
from typing import Any

from dnanalyze.report.figures.palette import turning

PAGE_FONT = "'Helvetica Neue','Liberation Sans',Arial,sans-serif"


def svg_of(fig: Any) -> str:
    """The figure as SVG text."""
    stream = io.StringIO()
    fig.savefig(stream, format="svg", metadata={"Date": None, "Creator": None}, dpi=150)
    text = stream.getvalue()
    text = text[text.index("<svg") :].replace("'DejaVu Sans'", PAGE_FONT)
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.S)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.S)
    text = re.sub(r'(?<= d=")[^"]+', lambda m: _path(m[0]), text)
    text = re.sub(r"(?<=style=\")[^\"]+", lambda m: turning(m[0].replace("; ", ";")), text)
    # only what is referred to needs a name
    used = set(re.findall(r'(?:url\(#|href="#)([^")]+)', text))
    text = re.sub(r' id="([^"]+)"', lambda m: m[0] if m[1] in used else "", text)
    text = re.sub(r"\n\s*", "\n", text)
    return re.sub(r"\n+(?=[</])", "", text)


def _path(commands: str) -> str:
    """A path to a tenth of a screen's pixel."""
    tidy = re.sub(r"(\.\d\d)\d+", r"\1", commands)
    return re.sub(r"\s+", " ", tidy).strip()


def named_apart(svg: str, prefix: str) -> str:
    """The names inside begin with ``prefix``, so that two pictures of a page never share one."""
    return re.sub(r'( id="|url\(#|href="#)', lambda m: m[1] + prefix, svg)
