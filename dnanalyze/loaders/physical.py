"""What the metadata of a frame can be: the range of each quantity, and what is wrong outside it."""

from __future__ import annotations

import math
from typing import Any

ABSOLUTE_ZERO = -273.15  # C
HOTTEST = 1000.0  # C; silicon melts at 1414 C, and no sensor is read above a few hundred
LONGEST = 1e8  # s, three years
LARGEST_GAIN = 1e9  # the largest ISO speeds are a few millions

# field: (smallest, itself allowed, largest, in words)
RANGES = {
    "temperature_c": (ABSOLUTE_ZERO, False, HOTTEST, f"above {ABSOLUTE_ZERO} and up to 1000 C"),
    "exposure_s": (0.0, True, LONGEST, "0 to 1e8 s"),
    "gain": (0.0, False, LARGEST_GAIN, "above 0 and up to 1e9"),
}


def fault(field: str, value: Any) -> str:
    """What is wrong with a value of ``temperature_c``, ``exposure_s`` or ``gain``; "" if nothing.

    None is unknown, which is right. Other fields may be any finite number.
    """
    if value is None:
        return ""
    try:
        number = math.nan if isinstance(value, (bool, str)) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        return f"{field} {str(value)[:40]!r} is no number"
    if field not in RANGES:
        return ""
    least, allowed, most, words = RANGES[field]
    if least < number <= most or (allowed and number == least):
        return ""
    return f"{field} {number:g} is out of range; valid: {words}"
