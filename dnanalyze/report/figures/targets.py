"""Values beside the limits that they were checked against."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from dnanalyze.checking.check import Check
from dnanalyze.report.figures.style import (
    GAUSSIAN,
    HAIRLINE,
    INK,
    MODEL,
    QUIET,
    Cell,
    Picture,
    panels,
)

CHARACTER = 0.062  # inch, of a name
FARTHEST = 3.0  # half widths of a limit, beyond which a value is drawn at the edge


def targets(checks: Sequence[Check], most: int = 40) -> Picture | None:
    """Where each value lies within its limits: -1 the lower limit, 1 the upper; violated first.

    Parameters
    ----------
    checks : sequence of Check
    most : int
        Targets that are drawn.
    """
    known = [(c, position(c)) for c in checks]
    placed = [(c, p) for c, p in known if p is not None]
    placed.sort(key=lambda pair: -abs(pair[1]))
    shown = placed[:most][::-1]
    name = CHARACTER * max((len(c.name) for c, _ in shown), default=0)
    return panels(
        [Cell(lambda ax: draw_targets(ax, shown), 3.6 + name, 1.0 + 0.2 * len(shown))],
        f"The {len(shown)} targets that lie closest to a limit or beyond it; blue is met, orange "
        "violated, grey violated and not enforced.",
        "Values of the simulation within the limits of the targets.",
    )


def draw_targets(ax: Any, shown: Sequence[tuple[Check, float]]) -> Any:
    """Values at their places within the limits.

    Parameters
    ----------
    ax : matplotlib axes
    shown : sequence of (Check, float)
        Each with its `position`.
    """
    if not shown:
        return ax
    ax.grid(False, axis="y")
    ax.axvspan(-1.0, 1.0, color=HAIRLINE, alpha=0.5, zorder=0)
    ax.axvline(0.0, color=QUIET, linewidth=0.6)
    for edge in (-1.0, 1.0):
        ax.axvline(edge, color=INK, linewidth=0.8, linestyle=(0, (3, 2)))
    for row, (check, place) in enumerate(shown):
        colour = MODEL if check.passed else GAUSSIAN if check.enforced else QUIET
        inside = max(-FARTHEST, min(FARTHEST, place))
        mark = "o" if inside == place else (">" if place > 0 else "<")
        ax.plot([inside], [row], mark, color=colour, markersize=5)
    ax.set_yticks(range(len(shown)), [c.name for c, _ in shown])
    ax.tick_params(axis="y", length=0)
    ax.set_xlim(-FARTHEST - 0.2, FARTHEST + 0.2)
    ax.set_ylim(-0.7, len(shown) - 0.3)
    ax.set_xlabel("value within its limits (−1 lower limit, 1 upper limit)")
    return ax


def position(check: Check) -> float | None:
    """-1 at the lower limit, 1 at the upper; of one limit, its share. None without a value."""
    if not math.isfinite(check.value):
        return None
    low, high = math.isfinite(check.lower), math.isfinite(check.upper)
    if low and high and check.upper > check.lower:
        return 2.0 * (check.value - check.lower) / (check.upper - check.lower) - 1.0
    if high and check.upper > 0:
        return float(check.value / check.upper)
    if low and check.value > 0:
        return float(-check.lower / check.value)
    return None
