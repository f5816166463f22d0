"""The error step by step as effects are added."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dnanalyze.report.figures.style import (
    ACCENT,
    HAIRLINE,
    INK,
    MODEL,
    QUIET,
    Picture,
    figure,
    picture,
    power_label,
)
from dnanalyze.report.words import is_number, number


def waterfall(names: Sequence[str], errors: Sequence[float]) -> Picture | None:
    """Bars from the error before each step to the error after it.

    Parameters
    ----------
    names : sequence of str
        What each step did; the first is the start.
    errors : sequence of float
        Error after each step.
    """
    steps = [(n, e) for n, e in zip(names, errors, strict=True) if is_number(e)]
    if not steps:
        return None

    def draw() -> Any:
        fig, axes = figure(1, 1, 3.1)
        ax = axes[0, 0]
        ax.grid(False, axis="x")
        values = [e for _, e in steps]
        log = max(values) / max(min(values), 1e-3) > 6
        foot = min(0.7, 0.8 * min(values)) if log else 0.0
        ax.bar(0, values[0] - foot, bottom=foot, color=QUIET, width=0.58)
        for place in range(1, len(values)):
            before, after = values[place - 1], values[place]
            shade = MODEL if after <= before else "#d55e00"
            ax.bar(place, before - after, bottom=after, color=shade, width=0.58)
            ax.plot([place - 1 + 0.29, place + 0.29], [before] * 2, color=INK, linewidth=0.5)
        end = len(values)
        ax.plot([end - 1 + 0.29, end + 0.29], [values[-1]] * 2, color=INK, linewidth=0.5)
        ax.bar(end, values[-1] - foot, bottom=foot, color=ACCENT, width=0.58)
        if log:
            ax.set_yscale("log")
            ax.yaxis.set_major_formatter(power_label)
            ax.yaxis.set_minor_formatter(lambda *_: "")
        ax.set_ylim(foot or 0, max(values) * (1.5 if log else 1.15))
        for place, value in enumerate([*values, values[-1]]):
            high = max(value, values[place - 1]) if 0 < place < end else value
            ax.annotate(number(value), (place, high), (0, 3), textcoords="offset points",
                        ha="center", va="bottom", fontsize=8)  # fmt: skip
        ax.axhline(1.0, color=INK, linewidth=0.8, linestyle=(0, (3, 2)))
        ax.annotate(
            "a second\nsensor", (1.0, 1.0), (5, 0), xycoords=("axes fraction", "data"),
            textcoords="offset points", va="center", fontsize=7.2, annotation_clip=False,
        )  # fmt: skip
        labels = [*(n.replace("_", "_\u200b") for n, _ in steps), "final"]
        many = len(labels) > 7
        ax.set_xticks(
            range(len(labels)), labels, **({"rotation": 30, "ha": "right"} if many else {})
        )
        ax.tick_params(axis="x", length=0)
        ax.spines["bottom"].set_color(HAIRLINE)
        ax.set_xlim(-0.5, end + 0.5)
        ax.set_ylabel("error")
        return fig

    return picture(
        draw,
        "The error step by step, on the half of the field that no fit saw; each bar spans the "
        "error before and after, with everything refitted. What every sensor has is fitted "
        "together: until all of it is named the paper's tables make up for the rest.",
        "Waterfall of the error: " + ", ".join(f"{n} {number(e)}" for n, e in steps),
    )
