"""How often each code occurs against its neighbours: missing codes, combs, clipping."""

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
    name_layers,
    picture,
    plane_note,
)

_NAMES = ("histogram_codes", "histogram_counts")
SHOWN, FEWEST = 64, 6  # codes in a panel


def roughness(drawn: Sequence[Layer], most: int = 3) -> Picture | None:
    """Counts of each code over the mean of its neighbourhood, around the median."""
    measured = drawn[0].statistics
    settings = [s for s in chosen(measured, most) if _ratio(s) is not None]
    if not settings:
        return None
    layers = [k for k in drawn if k.label != "Gaussian"]

    def draw() -> Any:
        fig, axes = figure(1, len(settings), 2.1, sharey=True)
        for ax, setting, title in zip(axes[0], settings, labels(settings), strict=True):
            ax.axhline(1, color="#8a929b", linewidth=0.7)
            for layer in layers:
                found = _ratio(layer.like(setting))
                if found is not None:
                    ax.step(*found, where="mid", color=layer.colour, linewidth=layer.width)
            ax.set_title(title)
            ax.set_xlabel("code [DN]")
            ax.set_ylim(0, max(2.0, ax.get_ylim()[1]))
        axes[0, 0].set_ylabel("counts over neighbours'")
        name_layers(fig, layers)
        return fig

    return picture(
        draw,
        "Counts of each code over the mean of the codes around it, near the median: 0 is a code "
        "that never occurs, 2 one that occurs twice as often as it should." + plane_note(measured),
        "Relative use of the codes around the median.",
    )


def _ratio(setting: Any) -> tuple[np.ndarray, np.ndarray] | None:
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
