"""Numbers and units as people and cameras write them: ``0,5 s``, ``1/30``, ``[ms] exposure``."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

_SCALES = (
    (1e-9, "ns nsec nanosec nanosecs nanosecond nanoseconds"),
    (1e-6, "us µs μs usec usecs microsec microsecs microsecond microseconds"),
    (1e-3, "ms msec msecs millisec millisecs millisecond milliseconds"),
    (1.0, "s sec secs second seconds"),
    (60.0, "min mins minute minutes"),
    (3600.0, "h hr hrs hour hours"),
    (86400.0, "d day days"),
)
SECONDS = {word: scale for scale, words in _SCALES for word in words.split()}
DEGREES = {
    **dict.fromkeys(("c", "degc", "deg c", "°c", "celsius", "degrees c", "degrees celsius"), "C"),
    **dict.fromkeys(("k", "kelvin", "kelvins", "deg k", "degk"), "K"),
    **dict.fromkeys(("f", "degf", "deg f", "°f", "fahrenheit"), "F"),
}
_MINUS = str.maketrans("\u2212\u2013\ufe63\uff0d", "----")
_NUMBER = re.compile(
    r"\s*([+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eEdD][+-]?\d{1,3}(?![\d.]))?)"
    r"\s*(?:/\s*(\d+(?:\.\d+)?))?\s*([^\d\s.,].*)?$"
)
_BRACKETS = re.compile(r"[\[(]([^\])]*)[\])]")
_FACTOR = r"(?:(?P<factor>\d+(?:\.\d+)?)\s*)?"


@dataclass(frozen=True)
class Reading:
    """A number that some text holds.

    Parameters
    ----------
    value : float
    unit : str
        What stands behind the number.
    unsure : str
        The other value that the text may mean ("1,250": 1250), or "".
    """

    value: float
    unit: str = ""
    unsure: str = ""


def plain_minus(text: str) -> str:
    """Text with every sign that is used as a minus as the hyphen that programs read."""
    return text.translate(_MINUS)


def read_number(value: Any) -> Reading | None:
    """The number that a value is or begins with; None where it is or holds none.

    Examples
    --------
    >>> read_number("0,5 s")
    Reading(value=0.5, unit='s', unsure='')
    """
    if isinstance(value, bool) or value is None:
        return None
    if isinstance(value, (tuple, list)) and len(value) == 2 and value[1]:
        try:
            value = value[0] / value[1]  # an EXIF rational
        except (TypeError, OverflowError):
            return None
    if isinstance(value, bytes):
        value = value.decode("ascii", "replace")
    if isinstance(value, str):
        return _read_text(plain_minus(value))
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        return None
    return Reading(number) if math.isfinite(number) else None


def _read_text(text: str) -> Reading | None:
    match = _NUMBER.match(text[:200])
    if match is None:
        return None
    digits = match[1]
    number = float(digits.replace(",", ".").lower().replace("d", "e"))
    below = float(match[2] or 1.0)
    if not math.isfinite(number) or below == 0:
        return None
    # a comma before three digits may separate thousands, unless nothing but a zero stands before
    thousands = re.fullmatch(r"[+-]?([1-9]\d{0,2}),\d{3}", digits)
    return Reading(
        number / below, (match[3] or "").strip(), digits.replace(",", "") if thousands else ""
    )


def unit_in(text: str, known: Mapping[str, Any]) -> tuple[float, Any] | None:
    """The unit that a comment names, anywhere: ``[ms]``, ``in units of 10 us``, ``..., kelvin``.

    Parameters
    ----------
    text : str
        The comment.
    known : mapping
        Unit in lower case to what it stands for.

    Returns
    -------
    tuple of (float, object) or None
        Factor before the unit (10 of "10 us"), and what the unit stands for.
    """
    text = text.lower()[:300]
    words = "|".join(map(re.escape, sorted(known, key=len, reverse=True)))
    unit = rf"{_FACTOR}(?P<unit>{words})"
    for held in _BRACKETS.findall(text):
        if match := re.fullmatch(rf"\s*(?:in\s+)?{unit}\.?\s*", held):
            return float(match["factor"] or 1.0), known[match["unit"]]
    spelled = "|".join(w for w in map(re.escape, known) if len(w) > 4)  # no word of English
    for pattern in (
        rf"\b(?:in|units?(?:\s+of|\s*[:=])?)\s+(?:units\s+of\s+)?{unit}(?![\w/])",
        rf"(?:^|[\s,;:=]){unit}\.?\s*$",
        rf"(?<!\w){_FACTOR}(?P<unit>{spelled})(?!\w)",
    ):
        if match := re.search(pattern, text):
            return float(match["factor"] or 1.0), known[match["unit"]]
    return None
