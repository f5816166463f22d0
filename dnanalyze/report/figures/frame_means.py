"""The frame mean from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.report.figures.style import (
    Layer,
    Picture,
    by_setting,
    curve,
)


def draw_frame_means(ax: Any, drawn: Sequence[Layer], setting: SettingStatistics) -> Any:
    """Mean of each frame minus the mean of all."""
    for layer in drawn:
        y = _means(layer.like(setting))
        if y is not None:
            ax.plot(np.arange(1, len(y) + 1), y, marker="o", markersize=2.6, **layer.line)
    if ax.lines:
        ax.set_xlabel("frame number")
        ax.set_ylabel("frame mean − mean of all [DN]")
        ax.xaxis.get_major_locator().set_params(integer=True)
    return ax


def frame_means(drawn: Sequence[Layer]) -> Picture | None:
    """One panel an operating point."""
    texts = (
        "Mean of each frame minus the mean of all frames of the operating point, in the order of "
        "capture; hot pixels are clipped.",
        "Frame means in the order in which the frames were taken.",
    )
    return by_setting(drawn, draw_frame_means, lambda s: _means(s) is not None, texts, height=2.0)


def _means(setting: SettingStatistics | None) -> np.ndarray | None:
    found = curve(setting, "frame_means")
    if found is None or found[0].size < 2:
        return None
    return found[0] - found[0].mean()
