"""Numbers as they are typed."""

from __future__ import annotations

import math

from dnanalyze.errors import InputError
from dnanalyze.loaders.physical import fault


def numbers(option: str, text: str | None, field: str) -> list[float]:
    """The numbers of ``25,45``; none where the option was left out.

    Parameters
    ----------
    option : str
        Its name, for the message.
    text : str or None
    field : {"temperature_c", "exposure_s", "gain"}
        What they are, which bounds them.

    Raises
    ------
    InputError
        Not numbers, not finite, or out of range.
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
        if wrong := fault(field, value):
            raise InputError(f"{option} {text}: {wrong}")
    return found


def celsius(option: str, text: str | None) -> list[float]:
    """Temperatures, C; see `numbers`."""
    return numbers(option, text, "temperature_c")


def rows_and_columns(text: str) -> tuple[int, int]:
    """The two numbers of ``1080x1920``.

    Raises
    ------
    InputError
        Not so written.
    """
    rows, _, columns = text.lower().partition("x")
    if not (rows.isdecimal() and columns.isdecimal() and len(text) < 20):
        raise InputError(f"--shape {text}: not ROWSxCOLUMNS, such as 1080x1920")
    return int(rows), int(columns)
