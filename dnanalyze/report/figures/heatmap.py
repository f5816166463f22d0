"""Discrepancy by statistic and operating point, and the error of each family."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import Any

import numpy as np

from dnanalyze.comparator.error import TOLERABLE
from dnanalyze.report.figures.palette import CALM, GRID, ON_DARK, ON_LIGHT, SOFT
from dnanalyze.report.figures.style import (
    GAUSSIAN,
    INK,
    MODEL,
    PAPER,
    QUIET,
    Cell,
    Picture,
    panels,
    quantity,
)
from dnanalyze.report.statistic_rows import info, worst
from dnanalyze.report.words import FAMILIES, family_title, is_number, number, point_label, varied

LINEAR = 3.0  # sigma up to which the colour scale is linear, logarithmic beyond
COLOUR_END = 30.0  # sigma at the end of the colours, at least
CLEAR, FEWEST = 2.0, 8  # statistics that are off by less are not worth a row, beyond the first few
ROW, COLUMN, MARGIN = 0.25, 0.46, 1.2  # inch; two lines of a name fit a row
LINE = 8.2  # points from line to line of a name
NAME = 44  # characters of a line of a name, so that a telephone shows names and columns
COLOURS = "RdBu_r"
Rows = Sequence[Mapping[str, Any]]


def draw_heatmap(ax: Any, rows: Rows, most: int = 36) -> Any:
    """Statistics with the largest discrepancies over the operating points.

    Parameters
    ----------
    ax : matplotlib axes
    rows : sequence of mapping
        Of a comparison; those of the first colour plane are drawn.
    most : int
        Statistics shown.
    """
    from matplotlib.colors import SymLogNorm

    names, points, grid = _grid(rows, most)
    if not names:
        return ax
    limit = _limit(float(np.nanmax(np.abs(grid))))
    norm = SymLogNorm(LINEAR, linscale=0.5, vmin=-limit, vmax=limit, base=10)
    ax.grid(visible=False)
    ax.set_facecolor(GRID)
    image = ax.imshow(grid, cmap=COLOURS, norm=norm, aspect="auto")
    ax.set_yticks([])
    _names(ax, _lines(names))
    turned = max(map(len, points)) > 7
    ax.set_xticks(range(len(points)), points, rotation=90 if turned else 0)
    ax.xaxis.tick_top()
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)
    _write(ax, grid, image)
    _families(ax, names, len(points))
    bar = ax.figure.colorbar(
        image, ax=ax, location="bottom", fraction=0.03, aspect=34, pad=0.02, shrink=0.9
    )
    bar.set_label(quantity("(measured − model) / σ, reproducibility standard deviation", ""))
    ticks = [
        t
        for t in ((3, 10, 30, 100) if limit <= 100 else (3, 10, 100, 1000, 10**4, 10**5))
        if t <= limit
    ]
    bar.set_ticks([*(-t for t in reversed(ticks)), 0, *ticks])
    bar.ax.xaxis.set_major_formatter(lambda v, _: f"{v:,.0f}".replace("-", "−"))
    bar.minorticks_off()
    bar.outline.set_visible(False)
    return ax


def discrepancies(rows: Rows, most: int = 36) -> Picture | None:
    """The heat map as a picture."""
    names, points, _ = _grid(rows, most)
    if not names:
        return None
    longest = max(len(line) for text in _lines(names) for line in text.split("\n"))
    head = 0.065 * max(map(len, points)) if max(map(len, points)) > 7 else 0.1
    cell = Cell(
        lambda ax: draw_heatmap(ax, rows, most),
        max(4.2, 0.062 * longest + COLUMN * len(points) + MARGIN),
        0.9 + head + ROW * len(names),
    )
    plane = names[0].get("plane", "")
    return panels(
        [cell],
        "Difference between sensor and model in reproducibility standard deviations σ (what two "
        f"sensors of the same design differ by). Red: the sensor has more; blue: less. Shown: the "
        f"{len(names)} statistics with the largest differences."
        + (f" Colour plane {plane}." if plane else ""),
        "Heat map of the discrepancy by statistic and operating point.",
    )


def _lines(names: Rows) -> list[str]:
    """The titles of the statistics, in lines of some `NAME` characters."""
    kept = (info(r["name"]).title.replace(" c/px", "\N{NO-BREAK SPACE}c/px") for r in names)
    return ["\n".join(wrap(text, NAME)).replace("\N{NO-BREAK SPACE}", " ") for text in kept]


def _grid(rows: Rows, most: int) -> tuple[list[Mapping[str, Any]], list[str], np.ndarray]:
    """The statistics, by family; the operating points; the discrepancies."""
    known = [r for r in rows if is_number(r["discrepancy"])]
    if not known:
        return [], [], np.empty((0, 0))
    own = [r for r in known if r.get("plane", "") == known[0].get("plane", "")]
    parts = varied(own) - {"plane"}
    points = list(dict.fromkeys(point_label(r, parts) for r in own))
    order = list(FAMILIES)
    names = worst(own, most=most)
    names = [r for n, r in enumerate(names) if n < FEWEST or abs(r["discrepancy"]) >= CLEAR]
    names.sort(key=lambda r: order.index(r["family"]) if r["family"] in order else 99)
    place = {r["name"]: n for n, r in enumerate(names)}
    grid = np.full((len(names), len(points)), np.nan)
    for row in own:
        if row["name"] in place:
            spot = place[row["name"]], points.index(point_label(row, parts))
            grid[spot] = row["discrepancy"]
    return names, points, grid


def _limit(largest: float) -> float:
    """The next of 30, 50, 100, 200, ... above: what is a few sigma stays pale."""
    if largest <= COLOUR_END:
        return COLOUR_END
    decade = 10.0 ** math.floor(math.log10(largest))
    return next(k * decade for k in (1, 2, 5, 10) if k * decade >= largest or k == 10)


def _write(ax: Any, grid: np.ndarray, image: Any) -> None:
    for (y, x), value in np.ndenumerate(grid):
        if np.isfinite(value):
            red, green, blue, _ = image.cmap(image.norm(value))
            bright = 0.299 * red + 0.587 * green + 0.114 * blue > 0.55
            sign = "+" if value > 0 else "−" if value < 0 else ""
            size = abs(value)
            text = f"{size:.0f}" if size < 9999.5 else f"{size / 1000:.0f}k"
            ax.text(x, y, text if text == "0" else sign + text, ha="center", va="center",
                    fontsize=6.8, color=ON_LIGHT if bright else ON_DARK)  # fmt: skip


def _names(ax: Any, names: Sequence[str]) -> None:
    """At the left of the rows; line by line, since a browser has letters of other widths."""
    for row, text in enumerate(names):
        lines = text.split("\n")
        for n, line in enumerate(lines):
            above = LINE * ((len(lines) - 1) / 2 - n)
            ax.annotate(line, (-0.5, row), (-4, above), textcoords="offset points", ha="right",
                        va="center", fontsize=7.5, color=SOFT, annotation_clip=False)  # fmt: skip


def _families(ax: Any, names: Rows, columns: int) -> None:
    """A hairline where one family ends, and its name at the right."""
    for n, row in enumerate(names):
        if n and row["family"] == names[n - 1]["family"]:
            continue
        if n:
            ax.plot([-0.5, columns - 0.5], [n - 0.5] * 2, color=INK, linewidth=0.8, clip_on=False)
        ax.annotate(family_title(row["family"]), (columns - 0.5, n), (5, 0), va="center",
                    textcoords="offset points", fontsize=7, color=SOFT,
                    annotation_clip=False)  # fmt: skip


BASELINES = {"paper": ("Wang 2025 model", QUIET), "gaussian": ("Gaussian model", GAUSSIAN)}


def draw_families(
    ax: Any, errors: Mapping[str, float], baselines: Mapping[str, float], error: float
) -> Any:
    """Error of each family, worst first, and below them the errors over all families."""
    known = {k: v for k, v in errors.items() if is_number(v)}
    if not known:
        return ax
    ranked = sorted(known.items(), key=lambda item: -item[1])
    bars = [(family_title(k), v, MODEL if v >= TOLERABLE else CALM) for k, v in ranked]
    own = "Wang 2025 model" if baselines.get("paper") == error else "this model"
    totals = [(f"all: {own}", error, MODEL)] + [
        (f"all: {text}", baselines[key], colour)
        for key, (text, colour) in BASELINES.items()
        if is_number(baselines.get(key)) and baselines[key] != error
    ]
    totals = [t for t in totals if is_number(t[1])]
    places = [*range(len(bars)), *(len(bars) + 0.5 + n for n in range(len(totals)))]
    names, values, colours = zip(*bars, *totals, strict=True)
    ax.grid(visible=False)
    ax.barh(places, values, color=colours, height=0.62)
    ax.set_yticks(places, names)
    ax.invert_yaxis()
    ax.tick_params(axis="y", length=0)
    top = max(values)
    if top > 20:
        ax.set_xscale("symlog", linthresh=1.0)
        ax.set_xticks([t for t in (0, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000) if t <= top * 1.3])
        ax.xaxis.set_major_formatter(lambda v, _: f"{v:,.0f}")
        ax.xaxis.minorticks_off()
    ax.set_xlim(0, max(1.2, top) * (1.6 if top > 20 else 1.14))
    ax.axvline(1.0, color=INK, linewidth=0.9, linestyle=(0, (3, 2)), zorder=3)
    for place, value in zip(places, values, strict=True):
        ax.annotate(number(value), (value, place),
                    (4, 0), textcoords="offset points", va="center", fontsize=7.5, zorder=4,
                    bbox={"facecolor": PAPER, "edgecolor": "none", "pad": 0.8})  # fmt: skip
    ax.set_xlabel("model error (dimensionless)")
    return ax


def families(
    errors: Mapping[str, float], baselines: Mapping[str, float], error: float
) -> Picture | None:
    """The errors of the families as a picture."""
    count = sum(map(is_number, errors.values())) + len(baselines)
    return panels(
        [Cell(lambda ax: draw_families(ax, errors, baselines, error), 4.4, 0.9 + 0.22 * count)],
        f"Model error of each family of statistics (dark blue: {TOLERABLE} or more), and over all "
        "families beside other models. "
        "Dashed line: 1, what a second sensor of the same design gives.",
        "Error of each family of statistics as bars.",
    )
