"""How many pixels lie beyond k robust standard deviations: the hot-pixel tail."""

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

_NAMES = ("exceedance_k", "exceedance_n")


def draw_exceedance(ax: Any, drawn: Sequence[Layer], setting: SettingStatistics) -> Any:
    """Pixels of the mean frame above its median by more than k robust standard deviations."""
    for layer in drawn:
        found = curve(layer.like(setting), *_NAMES)
        if found is None:
            continue
        k, n = found
        ax.plot(k, np.where(n > 0, n, np.nan), **layer.line)
        if layer.band:
            spread = 2 * np.sqrt(n)
            low = np.maximum(n - spread, 0.3)
            ax.fill_between(k, low, n + spread, where=n > 0, color=INK, alpha=0.15, lw=0)
    if not ax.lines:
        return ax
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_ylim(bottom=0.7)
    log_axis(ax.xaxis)
    log_axis(ax.yaxis)
    ax.set_xlabel("k [robust standard deviations]")
    ax.set_ylabel("pixels above k")
    return ax


def exceedance(drawn: Sequence[Layer]) -> Picture | None:
    """One panel an operating point."""
    texts = (
        "Number of pixels of the mean frame whose value exceeds the median by more than k robust "
        "standard deviations. Band: two standard errors of counting.",
        "Exceedance counts of the hot-pixel tail on logarithmic axes.",
    )
    return by_setting(drawn, draw_exceedance, has(*_NAMES), texts, share="count")
