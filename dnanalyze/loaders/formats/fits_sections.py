"""Active and overscan areas of a FITS image: DATASEC, TRIMSEC, BIASSEC, and those of amplifiers."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from typing import Any

from dnanalyze.loaders.captures import Window
from dnanalyze.loaders.recording import Area

_SECTION = re.compile(r"\s*\[\s*(\d+)\s*:\s*(\d+)\s*,\s*(\d+)\s*:\s*(\d+)\s*\]\s*")
# DATASECA (DECam, DESI), DSEC1 (Keck), DSEC11 (NOAO) and the overscan of the same ending
_OF_AMPLIFIER = re.compile(r"(DATASEC|DSEC|TRIMSEC|TSEC|BIASSEC|BSEC)([A-Z0-9]{1,3})")
_MOST_AMPLIFIERS = 64  # the most of one chip is 16


def areas(header: Mapping[str, Any], shape: tuple[int, int], notes: list[str]) -> dict[str, Area]:
    """The areas of an image by amplifier; one without name where there is one readout.

    Parameters
    ----------
    header : mapping
        Key words to values.
    shape : tuple of int
        (rows, columns) of the image.
    notes : list of str
        Takes what was assumed.

    Returns
    -------
    dict of str to Area
    """
    several = _amplifiers(header, shape, notes)
    if several:
        return several
    active, masked = _sections(header, shape, notes)
    return {"": Area(active, masked)}


def _amplifiers(
    header: Mapping[str, Any], shape: tuple[int, int], notes: list[str]
) -> dict[str, Area]:
    """Areas by the letter or number that ends their key words; none where they do not fit."""
    data: dict[str, Window] = {}
    bias: dict[str, Window] = {}
    for key, text in header.items():
        match = _OF_AMPLIFIER.fullmatch(key)
        window = section(text, shape) if match else None
        if match is None or window is None:
            continue
        of = bias if match[1].startswith("B") else data
        if match[1].startswith("D") or match[2] not in of:
            of[match[2]] = window
    if not 2 <= len(data) <= _MOST_AMPLIFIERS:
        return {}
    windows = list(data.values())
    if not all(_disjoint(a, b) for k, a in enumerate(windows) for b in windows[:k]):
        return {}
    common = Counter(w.shape for w in windows).most_common(1)[0][0]
    others = [name for name, w in data.items() if w.shape != common]
    if others:
        notes.append(
            f"The amplifiers {', '.join(others)[:80]} have areas of another size than the rest and "
            "are left out."
        )
    kept = [name for name, window in data.items() if window.shape == common]
    notes.append(
        f"Each image is read by {len(data)} amplifiers, taken as channels, each with its own black "
        f"level: {', '.join(kept)[:80]}."
    )
    found: dict[str, Area] = {}
    for name in kept:
        dark = bias.get(name)
        fits_in = dark is not None and all(_disjoint(dark, w) for w in windows)
        found[name] = Area(data[name], dark if fits_in else None, again=bool(found))
    return found


def section(text: Any, shape: tuple[int, int]) -> Window | None:
    """``[x1:x2,y1:y2]``, from 1 and inclusive, to a window; None where it does not fit.

    A section that counts down (``[100:1,1:200]``: read from the other side) is the same area.
    """
    match = _SECTION.fullmatch(str(text)[:80])
    if match is None:
        return None
    x1, x2, y1, y2 = map(int, match.groups())
    (x1, x2), (y1, y2) = sorted((x1, x2)), sorted((y1, y2))
    fits_in = 1 <= x1 <= x2 <= shape[1] and 1 <= y1 <= y2 <= shape[0]
    return Window(y1 - 1, y2, x1 - 1, x2) if fits_in else None


def _sections(
    header: Mapping[str, Any], shape: tuple[int, int], notes: list[str]
) -> tuple[Window | None, Window | None]:
    """Active area from DATASEC or TRIMSEC; overscan from BIASSEC, or what lies beside the data."""
    said = [key for key in ("DATASEC", "TRIMSEC", "BIASSEC") if str(header.get(key, "")).strip()]
    notes += [
        f"{key} {str(header[key])[:40]} does not fit the image of {shape[0]} x {shape[1]} pixels "
        "and is not used; active_rows and active_columns in the sidecar replace it."
        for key in said
        if section(header[key], shape) is None
    ]
    active = section(header.get("DATASEC"), shape) or section(header.get("TRIMSEC"), shape)
    bias = section(header.get("BIASSEC"), shape)
    if active == Window.whole(shape):
        active = None
    if active is None and bias is not None:
        active = max(_beside(bias, shape), key=_size)
        notes.append(
            f"BIASSEC {header['BIASSEC']} without DATASEC: the active area is taken to be "
            f"{_words(active)}."
        )
        return active, bias
    if active is None:
        return None, None
    if bias is not None and _disjoint(active, bias):
        return active, bias
    beside = _widest_margin(active, shape)
    if bias is not None:
        key = "DATASEC" if section(header.get("DATASEC"), shape) else "TRIMSEC"
        notes.append(
            f"BIASSEC {header['BIASSEC']} overlaps {key} {header[key]}; the overscan is taken to "
            f"be {_words(beside)}, which {key} leaves out."
        )
    return active, beside


def _words(window: Window) -> str:
    return (
        f"rows {window.top} to {window.bottom - 1}, columns {window.left} to {window.right - 1} "
        "(from 0)"
    )


def _size(window: Window) -> int:
    return window.shape[0] * window.shape[1]


def _disjoint(a: Window, b: Window) -> bool:
    return a.right <= b.left or b.right <= a.left or a.bottom <= b.top or b.bottom <= a.top


def _beside(window: Window, shape: tuple[int, int]) -> tuple[Window, ...]:
    """What lies left, right, above and below, over the whole other direction."""
    rows, columns = shape
    return (
        Window(0, rows, 0, window.left),
        Window(0, rows, window.right, columns),
        Window(0, window.top, 0, columns),
        Window(window.bottom, rows, 0, columns),
    )


def _widest_margin(active: Window, shape: tuple[int, int]) -> Window:
    rows, columns = shape
    margins = (
        Window(active.top, active.bottom, 0, active.left),
        Window(active.top, active.bottom, active.right, columns),
        Window(0, active.top, active.left, active.right),
        Window(active.bottom, rows, active.left, active.right),
    )
    return max(margins, key=_size)
