"""Discrepancy by statistic and operating point, and the error of each family."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dnanalyze.report.figures.style import (
    GAUSSIAN,
    INK,
    MODEL,
    QUIET,
    Picture,
    figure,
    picture,
    power_label,
)
from dnanalyze.report.tables import worst
from dnanalyze.report.words import FAMILIES, family_title, is_number, number, point_label, varied

BASELINES = (("paper", "paper's model", QUIET), ("gaussian", "Gaussian", GAUSSIAN))
LIMIT = 12.0  # floors at which the colour saturates


def discrepancies(rows: Sequence[Mapping[str, Any]], most: int = 36) -> Picture | None:
    """Statistics that are off the most, over the operating points; colours run to +-12 floors."""
    rows = [r for r in rows if is_number(r["discrepancy"])]
    if not rows:
        return None
    plane = rows[0].get("plane", "")
    own = [r for r in rows if r.get("plane", "") == plane]
    parts = varied(own) - {"plane"}
    points = list(dict.fromkeys(point_label(r, parts) for r in own))
    order = list(FAMILIES)
    names = worst(own, most=most)
    names.sort(key=lambda r: order.index(r["family"]) if r["family"] in order else 99)
    place = {r["name"]: n for n, r in enumerate(names)}
    grid = np.full((len(names), len(points)), np.nan)
    for row in own:
        if row["name"] in place:
            spot = place[row["name"]], points.index(point_label(row, parts))
            grid[spot] = row["discrepancy"]

    def draw() -> Any:
        fig, axes = figure(1, 1, 1.0 + 0.17 * len(names))
        ax = axes[0, 0]
        ax.grid(False)
        image = ax.imshow(grid, cmap="RdBu_r", vmin=-LIMIT, vmax=LIMIT, aspect="auto")
        ax.set_facecolor("#f1f3f5")
        ax.set_yticks(range(len(names)), [r["name"] for r in names])
        turn = {"rotation": 35, "ha": "left"} if max(map(len, points)) * len(points) > 90 else {}
        ax.set_xticks(range(len(points)), points, **turn)
        ax.xaxis.tick_top()
        ax.tick_params(length=0)
        for spine in ax.spines.values():
            spine.set_visible(False)
        if len(points) <= 10:
            _write(ax, grid)
        _families(ax, names, len(points))
        bar = fig.colorbar(image, ax=ax, shrink=min(1.0, 12 / len(names)), aspect=22, pad=0.01)
        bar.set_label("(measured − model) / floor")
        bar.outline.set_visible(False)
        return fig

    note = f" Colour plane {plane}." if plane else ""
    return picture(
        draw,
        "Discrepancy of each statistic in floors: red, the sensor has more of it than the model; "
        f"blue, less. The {len(names)} that are off the most are shown.{note}",
        "Heat map of the discrepancy by statistic and operating point.",
    )


def _write(ax: Any, grid: np.ndarray) -> None:
    for (y, x), value in np.ndenumerate(grid):
        if np.isfinite(value):
            shade = "#ffffff" if abs(value) > 0.62 * LIMIT else INK
            text = f"{value:+.0f}" if abs(value) < 9999 else f"{value:+.0e}"
            ax.text(x, y, text, ha="center", va="center", fontsize=6.6, color=shade)


def _families(ax: Any, names: Sequence[Mapping[str, Any]], columns: int) -> None:
    """A hairline where one family ends and the next begins."""
    for n in range(1, len(names)):
        if names[n]["family"] != names[n - 1]["family"]:
            ax.plot([-0.5, columns - 0.5], [n - 0.5] * 2, color=INK, linewidth=0.8, clip_on=False)


def families(
    errors: Mapping[str, float], baselines: Mapping[str, float], error: float
) -> Picture | None:
    """Error of each family as a bar, worst first, beside what a second sensor would give."""
    known = {k: v for k, v in errors.items() if is_number(v)}
    if not known:
        return None
    ranked = sorted(known.items(), key=lambda item: item[1])
    own = "the paper's model" if baselines.get("paper") == error else "this model"
    marks = [("a second sensor", 1.0, INK), (own, error, MODEL)]
    marks += [
        (text, baselines.get(key, np.nan), colour)
        for key, text, colour in (
            ("paper", "paper's model", QUIET),
            ("gaussian", "Gaussian", GAUSSIAN),
        )
    ]
    marks = [m for n, m in enumerate(marks) if is_number(m[1]) and (n < 2 or m[1] != error)]

    def draw() -> Any:
        fig, axes = figure(1, 1, 1.0 + 0.24 * len(ranked))
        ax = axes[0, 0]
        ax.grid(False)
        values = [v for _, v in ranked]
        colours = [MODEL if v >= 1.3 else "#8fbbd9" for v in values]
        ax.barh(range(len(ranked)), values, color=colours, height=0.62)
        ax.set_yticks(range(len(ranked)), [family_title(k) for k, _ in ranked])
        ax.tick_params(axis="y", length=0)
        ax.spines["left"].set_visible(False)
        top = max(*values, *(v for _, v, _ in marks))
        if top > 30:
            ax.set_xscale("symlog", linthresh=1.0)
            ax.xaxis.set_major_formatter(power_label)
        ax.set_xlim(0, top * 1.15)
        _lines(ax, marks, len(ranked))
        for n, value in enumerate(values):
            ax.annotate(
                number(value), (value, n), (4, 0), textcoords="offset points", va="center",
                fontsize=7.5, bbox={"facecolor": "#ffffff", "edgecolor": "none", "pad": 1},
            )  # fmt: skip
        ax.set_xlabel("error")
        return fig

    return picture(
        draw,
        "Error of each family of statistics. 1 is what a second sensor of the same make gives. "
        "The lines mark errors over all families.",
        "Error of each family of statistics as bars.",
    )


def _lines(ax: Any, marks: Sequence[tuple[str, float, str]], top: int) -> None:
    """A line an error, named above the bars; names that would touch stand on two levels."""
    low, high = ax.get_xlim()
    place = ax.transScale.transform
    span = place((high, 0))[0] - place((low, 0))[0]
    last, level = -1.0, 0
    for text, value, colour in sorted(marks, key=lambda m: m[1]):
        spot = (place((value, 0))[0] - place((low, 0))[0]) / span
        level = level + 1 if spot - last < 0.1 else 0
        last = spot
        dash = "-" if value == 1.0 else (0, (3, 2))
        ax.axvline(value, color=colour, linewidth=0.9, linestyle=dash, zorder=3)
        ax.annotate(
            text, (value, 1), (2, 3 + 9 * level), xycoords=("data", "axes fraction"),
            textcoords="offset points", color=colour, fontsize=7.2, annotation_clip=False,
        )  # fmt: skip
    ax.set_ylim(-0.6, top - 0.4)
