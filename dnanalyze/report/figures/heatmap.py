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
)
from dnanalyze.report.tables import worst
from dnanalyze.report.words import FAMILIES, family_title, is_number, number, point_label

LIMIT = 12.0  # floors at which the colour saturates


def discrepancies(rows: Sequence[Mapping[str, Any]], most: int = 36) -> Picture | None:
    """Statistics that are off the most, over the operating points; colours run to +-12 floors."""
    rows = [r for r in rows if is_number(r["discrepancy"])]
    if not rows:
        return None
    plane = rows[0].get("plane", "")
    own = [r for r in rows if r.get("plane", "") == plane]
    points = list(dict.fromkeys(point_label({**r, "plane": ""}) for r in own))
    order = list(FAMILIES)
    names = worst(own, most=most)
    names.sort(key=lambda r: order.index(r["family"]) if r["family"] in order else 99)
    place = {r["name"]: n for n, r in enumerate(names)}
    grid = np.full((len(names), len(points)), np.nan)
    for row in own:
        if row["name"] in place:
            spot = place[row["name"]], points.index(point_label({**row, "plane": ""}))
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

    def draw() -> Any:
        fig, axes = figure(1, 1, 0.7 + 0.24 * len(ranked))
        ax = axes[0, 0]
        ax.grid(False)
        values = [v for _, v in ranked]
        ax.barh(
            range(len(ranked)),
            values,
            color=[MODEL if v >= 1.3 else "#8fbbd9" for v in values],
            height=0.62,
        )
        ax.set_yticks(range(len(ranked)), [family_title(k) for k, _ in ranked])
        ax.tick_params(axis="y", length=0)
        ax.spines["left"].set_visible(False)
        top = max([*values, *(v for v in (error, *baselines.values()) if is_number(v))])
        if top > 30:
            ax.set_xscale("symlog", linthresh=1.0)
            from dnanalyze.report.figures.style import power_label

            ax.xaxis.set_major_formatter(power_label)
        for n, value in enumerate(values):
            ax.annotate(
                number(value),
                (value, n),
                (4, 0),
                textcoords="offset points",
                va="center",
                fontsize=7.5,
            )
        ax.axvline(1.0, color=INK, linewidth=0.9)
        marks = (("second sensor", 1.0, INK), ("all families", error, MODEL),
                 ("Gaussian", baselines.get("gaussian"), GAUSSIAN),
                 ("paper's model", baselines.get("paper"), QUIET))  # fmt: skip
        _marks(ax, marks, len(ranked))
        ax.set_xlabel("error")
        ax.set_xlim(0, top * 1.12)
        return fig

    return picture(
        draw,
        "Error of each family of statistics. 1 is what a second sensor of the same make gives. "
        "The lines mark the error over all families, and that of the baselines.",
        "Error of each family of statistics as bars.",
    )


def _marks(ax: Any, marks: Sequence[tuple[str, Any, str]], top: int) -> None:
    shown: list[float] = []
    for text, value, colour in marks:
        if not is_number(value) or any(abs(value - v) < 1e-6 * max(1, v) for v in shown):
            continue
        shown.append(value)
        ax.axvline(
            value, color=colour, linewidth=0.9, linestyle="-" if value == 1.0 else (0, (3, 2))
        )
        ax.annotate(text, (value, top - 0.45), (3, 0), textcoords="offset points",
                    color=colour, fontsize=7.2, annotation_clip=False)  # fmt: skip
