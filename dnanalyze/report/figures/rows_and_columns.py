"""Column and row means of the mean frame, and their spectra."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.report.figures.style import (
    Cell,
    Layer,
    Picture,
    chosen,
    curve,
    frequency_axis,
    has,
    labels,
    log_axis,
    main_run,
    panels,
    plane_note,
    shown_layers,
    thinned,
)

SIDES = ("column", "row")
PARTS = {"pattern": "DSNU", "temporal": "temporal noise", "frame": "single frame"}


def draw_profile(
    ax: Any, drawn: Sequence[Layer], setting: SettingStatistics, side: str = "column"
) -> Any:
    """Means of the columns (or rows) along the sensor; a Gaussian's say nothing."""
    for layer in shown_layers(drawn):
        found = curve(layer.like(setting), f"{side}_mean")
        if found is None:
            continue
        y = found[0] - np.nanmean(found[0])
        line = layer.line | {"linewidth": 0.7 * layer.width}
        ax.plot(*thinned(np.arange(len(y), dtype=float), y, 500), **line)
    if ax.lines:
        ax.set_xlabel(f"{side} number [pixels]")
        ax.set_ylabel(f"{side} mean − mean [DN]")
        ax.margins(x=0.01)
    return ax


def draw_line_spectrum(
    ax: Any,
    drawn: Sequence[Layer],
    setting: SettingStatistics,
    side: str = "column",
    part: str = "pattern",
) -> Any:
    """Power spectrum of the column (or row) means, in units of a pixel's variance."""
    for layer in drawn:
        found = curve(layer.like(setting), f"{side}_spectrum_f", f"{part}_{side}_spectrum")
        if found is None or not np.any(found[1] > 0):  # lines that are all alike
            continue
        ax.plot(*_pooled(found[0], found[1]), **layer.line)
    if ax.lines:
        ax.set_yscale("log")
        log_axis(ax.yaxis)
        frequency_axis(ax, "frequency [cycles/pixel]")
        ax.set_ylabel(f"power of the {side} means [DN²]")
    return ax


def profiles(drawn: Sequence[Layer]) -> Picture | None:
    """Line means along the sensor at the first and the last setting."""
    measured = drawn[0].statistics
    settings = chosen(measured, 2, lambda s: any(curve(s, f"{side}_mean") for side in SIDES))

    return panels(
        [
            Cell(
                partial(draw_profile, drawn=drawn, setting=s, side=side),
                4.4,
                1.9,
                title=f"{side} means, {title}",
            )
            for side in SIDES
            for s, title in zip(settings, labels(settings), strict=True)
        ],
        "Means of the columns and of the rows of the mean frame, minus their mean."
        + plane_note(measured, settings),
        "Column and row means.",
    )


def spectra(drawn: Sequence[Layer]) -> Picture | None:
    """Spectra of the line means at the first and the last setting that can tell them."""
    measured = drawn[0].statistics
    some = [p for p in PARTS if main_run(measured, has(f"{p}_column_spectrum"))]
    if "pattern" in some:
        some = [p for p in some if p != "frame"]

    cells, shown = [], []
    for side, part in product(SIDES, some):
        shown = chosen(measured, 2, has(f"{part}_column_spectrum"))
        cells += [
            Cell(
                partial(draw_line_spectrum, drawn=drawn, setting=s, side=side, part=part),
                2.5,
                2.2,
                title=f"{side}s, {PARTS[part]}, {title}",
            )
            for s, title in zip(shown, labels(shown), strict=True)
        ]
    return panels(
        cells,
        "Power spectra of the column and row means in units of the variance of a pixel: columns or "
        "rows without a component of their own lie at the power of the pixels."
        + plane_note(measured, shown),
        "Spectra of the column and row means.",
    )


def _pooled(f: np.ndarray, s: np.ndarray, most: int = 30) -> tuple[np.ndarray, np.ndarray]:
    """Frequency and power, pooled into steps of equal ratio.

    The Nyquist frequency is one real mode where the others are two: it is pooled with its
    neighbours, at half their weight, and never stands alone.
    """
    weight = np.where(np.isclose(f, 0.5), 0.5, 1.0)
    edges = np.unique(np.searchsorted(f, np.geomspace(f[0], f[-1], most)))
    if len(edges) > 1 and edges[-1] >= len(f) - 1:
        edges = edges[:-1]
    held = np.add.reduceat(weight, edges)
    return np.add.reduceat(f * weight, edges) / held, np.add.reduceat(s * weight, edges) / held
