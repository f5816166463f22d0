"""Histograms of the dark values on a log scale, one panel an operating point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.report.figures.style import (
    INK,
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
)

BINS = 160
TAIL = 2e-5  # share of the pixels beyond either end of the axis, as measured


def histograms(drawn: Sequence[Layer], most: int = 5) -> Picture | None:
    """Density of all frames' values; the band is what counting alone would scatter."""
    measured = drawn[0].statistics
    settings = [s for s in chosen(measured, most) if curve(s, *_NAMES)]
    if not settings:
        return None

    def draw() -> Any:
        fig, axes = figure(1, len(settings), 2.75, sharey=True)
        for ax, setting, title in zip(axes[0], settings, labels(settings), strict=True):
            _panel(ax, setting, drawn)
            ax.set_title(title)
        axes[0, 0].set_ylabel("share of pixels per DN")
        axes[0, 0].set_ylim(*_floor(settings))
        log_axis(axes[0, 0].yaxis)
        name_layers(fig, drawn)
        return fig

    names = ", ".join(k.label for k in drawn)
    return picture(
        draw,
        "Distribution of the dark values, logarithmic. The band around the measured curve is two "
        "standard errors of counting. The far tail has a panel of its own." + plane_note(measured),
        f"Histograms on a log scale: {names}, for {len(settings)} operating points.",
    )


_NAMES = ("histogram_codes", "histogram_counts")


def _panel(ax: Any, setting: SettingStatistics, drawn: Sequence[Layer]) -> None:
    codes, counts = curve(setting, *_NAMES)  # type: ignore[misc]
    low, high = _range(codes, counts)
    step = float(np.median(np.diff(codes))) if len(codes) > 1 else 1.0
    width = step * max(1, round((high - low) / BINS / step))
    for layer in drawn:
        found = curve(layer.like(setting), *_NAMES)
        if found is None:
            continue
        x, n, total = _binned(found, low, high, width)
        density = np.where(n > 0, n / total / width, np.nan)
        ax.plot(x, density, color=layer.colour, linestyle=layer.dash, linewidth=layer.width)
        if layer.band:
            spread = 2 * np.sqrt(n) / total / width
            ax.fill_between(
                x,
                np.maximum(density - spread, 1e-12),
                density + spread,
                color=INK,
                alpha=0.18,
                lw=0,
            )
    ax.set_yscale("log")
    ax.set_xlim(low, high)
    ax.set_xlabel("dark value [DN]")


def _range(codes: np.ndarray, counts: np.ndarray) -> tuple[float, float]:
    """From the lowest value to where little of the tail is left."""
    share = np.cumsum(counts) / counts.sum()
    low, middle = codes[np.searchsorted(share, TAIL)], codes[np.searchsorted(share, 0.5)]
    high = codes[np.minimum(len(codes) - 1, np.searchsorted(share, 1 - TAIL))]
    core = max(codes[np.searchsorted(share, 0.9)] - codes[np.searchsorted(share, 0.1)], 2.0)
    low, high = max(low, middle - 6 * core), min(high, middle + 6 * core)
    edge = 0.04 * (high - low) + 0.5
    return float(low - edge), float(high + edge)


def _binned(
    found: tuple[np.ndarray, ...], low: float, high: float, width: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Centres and counts of bins that hold the same number of codes each, and the count of all."""
    codes, counts = found
    edges = np.arange(low, high + width, width)
    n, _ = np.histogram(codes, bins=edges, weights=counts)
    return (edges[:-1] + edges[1:]) / 2, n, float(counts.sum())


def _floor(settings: Sequence[SettingStatistics]) -> tuple[float, float]:
    """One decade below what a single count makes, and above the highest peak."""
    lowest, highest = 1.0, 0.0
    for setting in settings:
        codes, counts = curve(setting, *_NAMES)  # type: ignore[misc]
        step = float(np.median(np.diff(codes))) if len(codes) > 1 else 1.0
        lowest = min(lowest, 0.5 / counts.sum() / step)
        highest = max(highest, counts.max() / counts.sum() / step)
    return lowest, 3 * highest
