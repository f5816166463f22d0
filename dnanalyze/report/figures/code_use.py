"""How often each code occurs beside its neighbours: missing codes, clipping."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.report.figures.style import (
    QUIET,
    Layer,
    Picture,
    by_setting,
    curve,
    shown_layers,
)

_NAMES = ("histogram_codes", "histogram_counts")
SHOWN, FEWEST = 64, 6  # codes in a panel


def draw_codes(ax: Any, drawn: Sequence[Layer], setting: SettingStatistics) -> Any:
    """Counts of each code over the mean of its neighbourhood, around the median."""
    for layer in drawn:
        found = _ratio(layer.like(setting))
        if found is not None:
            ax.step(*found, where="mid", **layer.line)
    if ax.lines:
        ax.axhline(1, color=QUIET, linewidth=0.7, zorder=0)
        ax.set_xlabel("code [DN]")
        ax.set_ylabel("count / mean count of neighbours")
        ax.set_ylim(0, max(2.0, ax.get_ylim()[1]))
    return ax


def roughness(drawn: Sequence[Layer]) -> Picture | None:
    """One panel an operating point."""
    texts = (
        "Count of each code divided by the mean count of the codes around it, near the median: 0 "
        "is a missing code, 2 a code that occurs twice as often as expected.",
        "Relative use of the codes around the median.",
    )
    shown = shown_layers(drawn)
    return by_setting(
        shown, draw_codes, lambda s: _ratio(s) is not None, texts, height=2.1, share="ratio"
    )


def _ratio(setting: SettingStatistics | None) -> tuple[np.ndarray, np.ndarray] | None:
    """Codes of the core and their counts over a parabola through the log of their neighbourhood."""
    found = curve(setting, *_NAMES)
    if found is None:
        return None
    codes, counts = found
    step = np.diff(codes)
    if not np.allclose(codes, np.round(codes)) or (len(step) and step.min() < 1):
        return None
    share = np.cumsum(counts) / counts.sum()
    low, middle, high = (int(codes[np.searchsorted(share, q)]) for q in (0.01, 0.5, 0.99))
    low, high = max(low, middle - SHOWN // 2), min(high, middle + SHOWN // 2)
    if high - low + 1 < FEWEST:
        return None
    reach = max(3, min(16, (high - low) // 6))
    wide = np.arange(low - reach, high + reach + 1)
    dense = np.zeros(len(wide))
    inside = (codes >= wide[0]) & (codes <= wide[-1])
    dense[(codes[inside] - wide[0]).astype(int)] = counts[inside]
    smooth = _smooth(dense, reach)[reach:-reach]
    return wide[reach:-reach], dense[reach:-reach] / np.maximum(smooth, 1.0)


def _smooth(counts: np.ndarray, reach: int) -> np.ndarray:
    """Local parabola by least squares (Savitzky and Golay), so that a peak is not flattened."""
    from scipy.signal import savgol_filter

    return np.asarray(savgol_filter(counts, 2 * reach + 1, 2, mode="nearest"))
