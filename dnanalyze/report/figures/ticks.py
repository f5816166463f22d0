"""Ticks of axes in plain text."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def power_label(value: float, _position: int = 0) -> str:
    """Tick of a log axis without mathematics fonts: 0.01, 100, 10⁵."""
    if value <= 0:
        return ""
    exponent = round(math.log10(value))
    if not math.isclose(value, 10.0**exponent, rel_tol=1e-6):
        return f"{value:g}"
    return f"{value:g}" if -3 <= exponent <= 3 else "10" + str(exponent).translate(_RAISED)


def log_axis(axis: Any) -> None:
    """Ticks at powers of ten in plain text; at 1, 2, 5 where the axis spans little."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    low, high = axis.get_view_interval()
    decades = math.log10(high / low) if low > 0 and high > low else 1.0
    subs: tuple[float, ...] = (1.0, 2.0, 5.0) if decades < 1.7 else (1.0,)
    if decades < 0.35:  # within a factor of two even 1, 2, 5 give too few
        subs = tuple(float(k) / 2 for k in range(2, 20))
    axis.set_major_locator(LogLocator(10, subs=subs, numticks=7))
    axis.set_major_formatter(FuncFormatter(power_label))
    axis.set_minor_locator(NullLocator())


FREQUENCIES = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)


def frequency_axis(ax: Any, label: str) -> None:
    """A logarithmic axis of spatial frequency that ends where the data end, 0.5 on a tick."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    low = min(float(np.min(line.get_xdata())) for line in ax.lines)
    high = max(float(np.max(line.get_xdata())) for line in ax.lines)
    ax.set_xscale("log")
    ax.set_xlim(0.9 * low, 1.04 * max(high, 0.5))
    ticks = [f for f in FREQUENCIES if f >= 0.9 * low]
    ax.xaxis.set_major_locator(FixedLocator(ticks if len(ticks) < 7 else ticks[::-2][::-1]))
    ax.xaxis.set_major_formatter(FuncFormatter(power_label))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.set_xlabel(label)
