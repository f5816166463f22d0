"""The paper's figure 2: high-frequency power over mid-frequency power against temperature."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.report.figures.style import GAUSSIAN, INK, QUIET, Picture, figure, picture


def suppression(series: Any) -> Picture | None:
    """Measured suppression with what an unfiltered sensor and linear crosstalk would give.

    Parameters
    ----------
    series : SuppressionSeries or None
    """
    if series is None:
        return None
    celsius = series.temperature_c

    def draw() -> Any:
        fig, axes = figure(1, 1, 3.3)
        ax = axes[0, 0]
        low, high = (np.exp(series.log_ratio + k * series.se) for k in (-2, 2))
        crosstalk = np.exp(series.crosstalk)
        ax.plot(celsius, np.ones(len(celsius)), color=QUIET, linewidth=1.0)
        ax.plot(celsius, crosstalk, color=GAUSSIAN, linewidth=1.0, linestyle=(0, (4, 2)))
        ax.vlines(celsius, low, high, color=INK, alpha=0.35, linewidth=3.2)
        ax.plot(celsius, np.exp(series.log_ratio), "o-", color=INK, markersize=4)
        ax.set_ylim(0, max(1.25, 1.08 * float(high.max())))
        ends = (
            (1.0, "unfiltered", QUIET),
            (crosstalk[-1], f"crosstalk {100 * series.phi:.2g} %", GAUSSIAN),
            (float(np.exp(series.log_ratio[-1])), "measured", INK),
        )
        for y, text, colour in _apart(ends, 0.05 * ax.get_ylim()[1]):
            ax.annotate(
                text, (celsius[-1], y), (7, 0), textcoords="offset points", va="center",
                color=colour, annotation_clip=False,
            )  # fmt: skip
        ax.set_xlabel("°C")
        ax.set_ylabel("high over mid-frequency power")
        return fig

    return picture(
        draw,
        "Power above .45 cycles/pixel over power from .03 to .12, axes masked, over temperature. "
        "An unfiltered sensor stays at 1. Defect correction pulls it down when warm; denoise, "
        "often, when cold. Linear crosstalk falls, then levels off: the dashed curve is the one "
        "that fits best. Bars: two standard errors.",
        "High-frequency suppression over temperature.",
    )


def _apart(ends: tuple[tuple[float, str, str], ...], least: float) -> list[tuple[float, str, str]]:
    """The labels moved upwards where they would overlap."""
    placed: list[tuple[float, str, str]] = []
    for y, text, colour in sorted(ends):
        floor = placed[-1][0] + least if placed else -np.inf
        placed.append((max(y, floor), text, colour))
    return placed
