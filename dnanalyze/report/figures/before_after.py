"""What one effect does to the statistics: before it and after it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import Any

import numpy as np

from dnanalyze.digits import is_number
from dnanalyze.report.figures.over_operating_points import draw_statistic, tells
from dnanalyze.report.figures.style import (
    GAUSSIAN,
    HAIRLINE,
    MODEL,
    Cell,
    Layer,
    Picture,
    log_axis,
    panels,
)
from dnanalyze.report.statistic_rows import info

MAX_STATISTICS = 8  # statistics shown
FLOOR = 0.3  # standard deviations, at the left end of the axis
Rows = Sequence[Mapping[str, Any]]


def largest(rows: Rows) -> dict[str, float]:
    """Largest deviation of each statistic over the operating points, standard deviations.

    One that the model does not determine states no deviation.
    """
    found: dict[str, float] = defaultdict(float)
    for row in rows:
        if is_number(row["simulated"]):
            found[row["name"]] = max(found[row["name"]], abs(row["discrepancy"]))
    return dict(found)


def changed(before: Rows, after: Rows, most: int = MAX_STATISTICS) -> list[str]:
    """The statistics that an effect corrects most; of those that say the same, the first."""
    was, now = largest(before), largest(after)
    fall = {n: np.log(max(was[n], 1.0) / max(now[n], 1.0)) * was[n] ** 0.5 for n in was if n in now}
    ranked = sorted((n for n in fall if fall[n] > 0), key=lambda n: -fall[n])
    kinds: dict[str, str] = {}
    for name in ranked:
        kinds.setdefault(name.rstrip("0123456789_."), name)
    return list(kinds.values())[:most]


def draw_changes(ax: Any, before: Rows, after: Rows, labels: tuple[str, str]) -> Any:
    """A line a statistic, from its largest deviation before to that after.

    Parameters
    ----------
    ax : matplotlib axes
    before, after : sequence of mapping
        Rows of a comparison.
    labels : tuple of str
        Of the two models.
    """
    names = changed(before, after)
    if not names:
        return ax
    was, now = largest(before), largest(after)
    places = np.arange(len(names))
    ends = [np.maximum([d[n] for n in names], FLOOR) for d in (was, now)]
    ax.hlines(places, *ends, color=HAIRLINE, linewidth=4)
    ax.plot(ends[0], places, "o", color=GAUSSIAN, markersize=5.5, label=labels[0])
    ax.plot(ends[1], places, "o", color=MODEL, markersize=5.5, label=labels[1])
    ax.set_xscale("log")
    log_axis(ax.xaxis)
    ax.grid(visible=False, axis="y")
    ax.tick_params(axis="y", length=0, labelsize=7)
    ax.set_yticks(places, [_lines(info(n).title) for n in names])
    ax.set_ylim(len(names) - 0.4, -0.6)
    ax.set_xlabel("largest |measured − model| [σ]")
    return ax


def before_after(
    drawn: Sequence[Layer], before: Rows, after: Rows, labels: tuple[str, str]
) -> Picture | None:
    """The statistics corrected most, and two of them over the operating points.

    Parameters
    ----------
    drawn : sequence of Layer
        Measured, before, after.
    before, after : sequence of mapping
        Rows of a comparison of either model.
    labels : tuple of str
        Of the two models.
    """
    names = changed(before, after)
    if not names:
        return None
    height = 1.0 + 0.27 * len(names)

    def over(name: str) -> Cell:
        return Cell(lambda ax: draw_statistic(ax, drawn, name), 2.45, height)

    told = [n for n in names if tells(drawn, n)]
    plain = sorted(told, key=lambda n: -_apart(drawn, n))[:2]
    first = Cell(
        lambda ax: draw_changes(ax, before, after, labels), 10.2 - 2.65 * len(plain), height
    )
    return panels(
        [first, *map(over, plain)],
        "Statistics that the effect corrects most: largest deviation over the operating points, in "
        "standard deviations between sensors of one design (σ), before and after. Other curves: "
        "measured with two standard errors, and both models.",
        f"Statistics before and after: {', '.join(info(n).title for n in names)}.",
    )


def _lines(title: str) -> str:
    return "\n".join(wrap(title, 56, max_lines=2, placeholder=" …"))


def _apart(drawn: Sequence[Layer], name: str) -> float:
    """Largest distance of the models, as a share of the range of all values, as they are drawn."""
    scale = info(name).scale
    found = [
        [scale.coordinate(s.values[name].value) for s in k.statistics.settings if name in s.values]
        for k in drawn
    ]
    _, before, after = (np.array(f[: min(map(len, found))]) for f in found)
    everything = np.concatenate([np.array(f) for f in found])
    ptp = float(np.nanmax(everything) - np.nanmin(everything)) if everything.size else 0.0
    return float(np.nanmax(np.abs(after - before))) / ptp if ptp > 0 else 0.0
