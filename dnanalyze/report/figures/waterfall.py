"""The error step by step as effects are added."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from dnanalyze.diagnosis.results import Step
from dnanalyze.report.figures.style import (
    ACCENT,
    GAUSSIAN,
    INK,
    MODEL,
    PAPER,
    QUIET,
    Cell,
    Picture,
    panels,
)
from dnanalyze.report.refinement_stages import BASELINE_STAGE, stages
from dnanalyze.report.words import is_number, number

RANGE = 6.0  # ratio of the errors from which the axis is logarithmic


def draw_waterfall(ax: Any, steps: Sequence[Step]) -> Any:
    """Bars from the error before each stage to the error after it.

    Parameters
    ----------
    ax : matplotlib axes
    steps : sequence of Step
        Of a refinement; the first is the start.
    """
    shown = [s for s in stages(steps) if is_number(s.error)]
    if not shown:
        return ax
    values = [s.error for s in shown]
    log = max(values) / max(min(values), 1e-3) > RANGE
    foot = min(0.5, 0.5 * min(values)) if log else 0.0
    ends = [0, len(values)] if len(values) > 1 else [0]
    ax.bar(0, values[0] - foot, bottom=foot, color=QUIET, width=0.58)
    for place in range(1, len(values)):
        before, after = values[place - 1], values[place]
        ax.bar(place, before - after, bottom=after, color=MODEL if after <= before else GAUSSIAN,
               width=0.58)  # fmt: skip
    if len(ends) > 1:
        ax.bar(ends[1], values[-1] - foot, bottom=foot, color=ACCENT, width=0.58)
    heights = [*values, values[-1]][: ends[-1] + 1]
    for place, value in enumerate(heights[:-1]):  # the level from one bar to the next
        ax.plot([place + 0.29, place + 0.71], [value] * 2, color=INK, linewidth=0.6)
    if log:
        ax.set_yscale("log")
        ticks = (0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
        ax.set_yticks([t for t in ticks if foot <= t <= 1.5 * max(values)])
        ax.yaxis.set_major_formatter(lambda v, _: f"{v:g}")
        ax.yaxis.minorticks_off()
    ax.set_ylim(foot or 0, max(*values, 1.0) * (1.5 if log else 1.15))
    for place, value in enumerate(heights):
        high = max(value, values[place - 1]) if 0 < place < len(values) else value
        ax.annotate(number(value), (place, high), (0, 3), textcoords="offset points",
                    ha="center", va="bottom", fontsize=8, zorder=4,
                    bbox={"facecolor": PAPER, "edgecolor": "none", "pad": 0.6})  # fmt: skip
    ax.axhline(1.0, color=INK, linewidth=0.8, linestyle=(0, (3, 2)), zorder=1.5)
    names = [*(s.name for s in shown), "final model"][: ends[-1] + 1]
    ax.set_xticks(range(len(names)), [_lines(n) for n in names])
    ax.grid(visible=False, axis="x")
    ax.tick_params(axis="x", length=0)
    ax.set_xlim(-0.5, len(names) - 0.5)
    ax.set_ylabel("model error" + (" (logarithmic)" if log else ""))
    return ax


def _lines(name: str) -> str:
    """A name in lines of some twelve characters, for an axis."""
    lines = [""]
    for part in name.replace("_", "_ ").split(" "):
        gap = "" if lines[-1].endswith("_") or not lines[-1] else " "
        if len(lines[-1]) + len(gap) + len(part) > 12 and lines[-1]:
            lines.append(part)
        else:
            lines[-1] += gap + part
    return "\n".join(lines)


def waterfall(steps: Sequence[Step]) -> Picture | None:
    """The waterfall as a picture."""
    return waterfalls({"": steps})


def waterfalls(parts: Mapping[str, Sequence[Step]]) -> Picture | None:
    """A waterfall for each part of a refinement, such as an HDR channel, under its name."""

    def cell(name: str, steps: Sequence[Step]) -> Cell:
        wide = max(3.6, 0.95 * (len(stages(steps)) + 1) + 0.6)
        return Cell(lambda ax: draw_waterfall(ax, steps), wide, 3.0, title=name)

    shown = {name: stages(steps) for name, steps in parts.items()}
    text = "; ".join(
        f"{name}: " * bool(name) + ", ".join(f"{s.name} {number(s.error)}" for s in own)
        for name, own in shown.items()
    )
    return panels(
        [cell(name, steps) for name, steps in parts.items()],
        "Model error after each step, measured on the held-out half of the field; after each step "
        "all parameters are fitted again. Dashed line: 1, a second sensor of the same design."
        + (
            f" The {BASELINE_STAGE} is one step: its effects are fitted together."
            if any(s.name == BASELINE_STAGE for own in shown.values() for s in own)
            else ""
        ),
        f"Waterfall of the error: {text}",
    )
