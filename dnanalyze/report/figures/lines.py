"""Column and row means of the fixed pattern, and their spectra."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.report.figures.style import (
    Layer,
    Picture,
    chosen,
    curve,
    figure,
    labels,
    log_axis,
    name_layers,
    picture,
    plane_note,
    thinned,
)

SIDES = ("column", "row")
PARTS = {"pattern": "their spectrum", "temporal": "between frames", "frame": "their spectrum"}


def profiles(drawn: Sequence[Layer]) -> Picture | None:
    """Line means along the sensor for the coldest and the warmest setting, spectra beside them."""
    measured = drawn[0].statistics
    settings = chosen(measured, 2)
    if not any(curve(s, f"{side}_mean") for s in settings for side in SIDES):
        return None
    named = list(zip(settings, labels(settings), strict=True))
    rows = [(side, s, t) for side in SIDES for s, t in named if curve(s, f"{side}_mean")]
    parts = [p for p in PARTS if any(curve(s, f"{p}_column_spectrum") for s in settings)]
    if "pattern" in parts:
        parts = [p for p in parts if p != "frame"]

    def draw() -> Any:
        ratios = (2.2, *(1.0 for _ in parts))
        height = 0.5 + 1.55 * len(rows)
        fig, axes = figure(len(rows), len(ratios), height, gridspec_kw={"width_ratios": ratios})
        for (side, setting, title), (line, *spectra) in zip(rows, axes, strict=True):
            _profile(line, drawn, setting, side)
            line.set_title(f"{side} means, {title}")
            for ax, part in zip(spectra, parts, strict=True):
                _spectra(ax, drawn, setting, side, part)
                ax.set_title(PARTS[part])
        axes[-1, 0].set_xlabel("position [pixels]")
        for ax in axes[-1, 1:]:
            ax.set_xlabel("cycles/pixel")
        if parts:
            axes[0, 1].set_ylabel("DN²")
        name_layers(fig, drawn)
        return fig

    return picture(
        draw,
        "Means of the columns and rows, and their power spectrum in units of a pixel's "
        "variance: lines that carry nothing of their own lie at the level of the pixels."
        + plane_note(measured),
        "Column and row means with their spectra.",
    )


def _profile(ax: Any, drawn: Sequence[Layer], setting: Any, side: str) -> None:
    """Means along the sensor; the Gaussian's say nothing beside the model's."""
    for layer in drawn:
        found = curve(layer.like(setting), f"{side}_mean")
        if found is None or layer.label == "Gaussian":
            continue
        y = found[0] - np.nanmean(found[0])
        width = 0.7 * layer.width
        ax.plot(
            *thinned(np.arange(len(y), dtype=float), y, 900), color=layer.colour, linewidth=width
        )
    ax.set_ylabel("DN")
    ax.margins(x=0.01)


def _spectra(ax: Any, drawn: Sequence[Layer], setting: Any, side: str, part: str) -> None:
    for layer in drawn:
        found = curve(layer.like(setting), f"{side}_spectrum_f", f"{part}_{side}_spectrum")
        if found is None or not np.any(found[1] > 0):  # lines that are all alike
            continue
        f, s = _pooled(found[0], found[1])
        ax.plot(f, s, color=layer.colour, linestyle=layer.dash, linewidth=layer.width)
    if ax.lines:
        ax.set_xscale("log")
        ax.set_yscale("log")
        log_axis(ax.xaxis)
        log_axis(ax.yaxis)
    else:
        ax.set_axis_off()


def _pooled(f: np.ndarray, s: np.ndarray, most: int = 30) -> tuple[np.ndarray, np.ndarray]:
    """Frequency and power, pooled into steps of equal ratio."""
    edges = np.unique(np.searchsorted(f, np.geomspace(f[0], f[-1], most)))
    counts = np.diff(np.append(edges, len(f)))
    return np.add.reduceat(f, edges) / counts, np.add.reduceat(s, edges) / counts
