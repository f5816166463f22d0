"""Lists of numbers as they are typed."""

from __future__ import annotations

import math

from dnanalyze.errors import InputError

ABSOLUTE_ZERO = -273.15  # C


def numbers(option: str, text: str | None, least: float = -math.inf) -> list[float]:
    """The numbers of ``25,45``; none where the option was left out.

    Parameters
    ----------
    option : str
        Its name, for the message.
    text : str or None
    least : float
        Smaller ones are refused.

    Raises
    ------
    InputError
        Not numbers, not finite, or too small.
    """
    if text is None:
        return []
    try:
        found = [float(part) for part in text.split(",")]
    except ValueError:
        found = [math.nan]
    if not all(map(math.isfinite, found)):
        raise InputError(f"{option} {text}: not numbers with commas between, such as 25,45")
    for value in found:
        if value < least:
            raise InputError(f"{option} {text}: {value:g} is below {least:g}")
    return found


def celsius(option: str, text: str | None) -> list[float]:
    """Temperatures, C; see `numbers`."""
    return numbers(option, text, ABSOLUTE_ZERO)
