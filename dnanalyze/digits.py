"""Numbers as short text, the same in sentences, tables and pages."""

from __future__ import annotations

import math
from typing import Any


def is_number(value: Any) -> bool:
    """A finite number, not a truth value."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def minus(text: str) -> str:
    """A formatted number with the minus sign of print, as matplotlib writes it.

    Examples
    --------
    >>> minus(f"{-2.4:+.1f}")
    '−2.4'
    """
    return text.replace("-", "\N{MINUS SIGN}")


def number(value: Any, digits: int = 3) -> str:
    """Short text of a number: ``digits`` significant, ``1,060``, ``−1.5 × 10⁷``.

    Examples
    --------
    >>> number(1056.2), number(-0.001234), number(1.5e7)
    ('1,060', '−0.00123', '1.5 × 10⁷')
    """
    if not is_number(value):
        return "–"
    if value == 0:
        return "0"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = int(exponent)
    if power >= 6 or power < -4:
        return f"{minus(_trimmed(mantissa))} × 10{str(power).translate(_RAISED)}"
    rounded = float(f"{mantissa}e{exponent}")
    return minus(_trimmed(f"{rounded:,.{max(0, digits - 1 - power)}f}"))


def resolving(low: float, high: float) -> int:
    """Significant digits that show an interval: three, more where its width has less than two.

    Examples
    --------
    >>> resolving(1.9, 2.1), resolving(88.9661, 89.0403), resolving(-math.inf, 1.3)
    (3, 5, 3)
    """
    largest, width = max(abs(low), abs(high)), abs(high - low)
    if not 0 < width < largest < math.inf:
        return 3
    return max(3, math.floor(math.log10(largest)) - math.floor(math.log10(width)) + 2)


def _trimmed(text: str) -> str:
    """Without the zeros that end its decimals."""
    return text.rstrip("0").rstrip(".") if "." in text else text


_SYMBOLS = (("ln DN", "ln(DN)"), ("^2", "²"), ("^3", "³"), ("e-", "e⁻"))


def symbol(unit: str) -> str:
    """A unit as it is printed; nothing for a dimensionless number.

    Examples
    --------
    >>> symbol("DN^2"), symbol("e-/s"), symbol("1")
    ('DN²', 'e⁻/s', '')
    """
    for plain, printed in _SYMBOLS:
        unit = unit.replace(plain, printed)
    return {"1": "", "C": "°C"}.get(unit, unit)


def unit_text(unit: str) -> str:
    """What stands behind a number: a space and the unit, or nothing."""
    return f" {symbol(unit)}" if symbol(unit) else ""


def with_error(value: Any, error: Any, unit: str = "") -> str:
    """``1.23 ± 0.04 DN``, the error to two digits and the value to the same decimal place."""
    tail = unit_text(unit)
    if not (is_number(value) and is_number(error)) or error <= 0:
        return number(value) + tail
    places = 1 - math.floor(math.log10(error))
    value = round(value, places) + 0.0  # never −0.0
    error, decimals = round(error, places), max(0, places)
    if decimals > 6 or abs(value) >= 1e6:
        return f"{number(value, 4)} ± {number(error, 2)}{tail}"
    return f"{minus(f'{value:,.{decimals}f}')} ± {error:,.{decimals}f}{tail}"
