"""Figure 2 of Wang 2025: high-frequency power over mid-frequency power against temperature."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.detection.series import SuppressionSeries
from dnanalyze.report.figures.style import GAUSSIAN, INK, QUIET, Cell, Picture, panels


def draw_suppression(ax: Any, series: SuppressionSeries | None) -> Any:
    """Measured suppression with what an unfiltered sensor and linear crosstalk would give.

    Parameters
    ----------
    ax : matplotlib axes
    series : SuppressionSeries or None
    """
    if series is None:
        return ax
    celsius = series.temperature_c
    low, high = (np.exp(series.log_ratio + k * series.se) for k in (-2, 2))
    crosstalk = np.exp(series.crosstalk)
    ax.vlines(celsius, low, high, color=INK, alpha=0.35, linewidth=3.2)
    ax.plot(celsius, np.exp(series.log_ratio), "o-", color=INK, markersize=4, label="measured")
    ax.plot(celsius, np.ones(len(celsius)), color=QUIET, linewidth=1.0, label="unfiltered sensor")
    ax.plot(celsius, crosstalk, color=GAUSSIAN, linewidth=1.0, linestyle=(0, (4, 2)),
            label=f"crosstalk of {100 * series.phi:.2g} %")  # fmt: skip
    ax.set_ylim(0, max(1.25, 1.08 * float(high.max())))
    ax.set_xlabel("temperature [°C]")
    ax.set_ylabel("high- / mid-frequency power")
    return ax


def suppression(series: SuppressionSeries | None) -> Picture | None:
    """The series as a picture."""
    return panels(
        [Cell(lambda ax: draw_suppression(ax, series), 4.4, 2.8)],
        "Power above 0.45 cycles/pixel divided by the power from 0.03 to 0.12, rows and columns "
        "left out. An unfiltered sensor stays at 1. Defect-pixel correction lowers it at high "
        "temperature; denoising often at low temperature. Linear crosstalk lowers it and then "
        "levels off: the dashed curve fits best. Bars: two standard errors.",
        "High-frequency suppression over temperature.",
    )
