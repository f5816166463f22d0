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
    by_setting,
    curve,
    has,
    log_axis,
)

BINS = 160
TAIL = 2e-5  # share of the pixels beyond either end of the axis, as measured
_NAMES = ("histogram_codes", "histogram_counts")


def draw_histogram(ax: Any, drawn: Sequence[Layer], setting: SettingStatistics) -> Any:
    """Density of all frames' values; the band is what counting alone would scatter."""
    found = curve(setting, *_NAMES)
    if found is None:
        return ax
    codes, counts = found
    low, high = _range(codes, counts)
    step = float(np.median(np.diff(codes))) if len(codes) > 1 else 1.0
    width = step * max(1, round((high - low) / BINS / step))
    for layer in drawn:
        own = curve(layer.like(setting), *_NAMES)
        if own is None:
            continue
        x, n, total = _binned(own, low, high, width)
        density = np.where(n > 0, n / total / width, np.nan)
        ax.plot(x, density, **layer.line)
        if layer.band:
            spread = 2 * np.sqrt(n) / total / width
            below = np.maximum(density - spread, 1e-12)
            ax.fill_between(x, below, density + spread, color=INK, alpha=0.18, lw=0)
    ax.set_yscale("log")
    ax.set_xlim(low, high)
    # from half of what a single count makes to above the highest peak
    ax.set_ylim(0.5 / counts.sum() / step, 3 * counts.max() / counts.sum() / step)
    log_axis(ax.yaxis)
    ax.set_xlabel("dark signal [DN]")
    ax.set_ylabel("probability density [1/DN]")
    return ax


def histograms(drawn: Sequence[Layer]) -> Picture | None:
    """One panel an operating point."""
    texts = (
        "Distribution of the dark signal of all pixels and frames on a logarithmic scale. Band: "
        "two standard errors of counting. The panel of the hot-pixel tail shows the far tail.",
        f"Histograms on a log scale: {', '.join(k.label for k in drawn)}.",
    )
    return by_setting(drawn, draw_histogram, has(*_NAMES), texts, height=2.6, share="density")


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
