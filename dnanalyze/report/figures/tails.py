"""How many pixels lie beyond k robust sigmas: the hot-pixel tail."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

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

_NAMES = ("exceedance_k", "exceedance_n")


def exceedance(drawn: Sequence[Layer], most: int = 5) -> Picture | None:
    """Pixels of the fixed pattern above the median by more than k robust sigmas."""
    measured = drawn[0].statistics
    settings = [s for s in chosen(measured, most) if curve(s, *_NAMES)]
    if not settings:
        return None

    def draw() -> Any:
        fig, axes = figure(1, len(settings), 2.6, sharey=True)
        for ax, setting, title in zip(axes[0], settings, labels(settings), strict=True):
            for layer in drawn:
                found = curve(layer.like(setting), *_NAMES)
                if found is None:
                    continue
                k, n = found
                seen = np.where(n > 0, n, np.nan)
                ax.plot(k, seen, color=layer.colour, linestyle=layer.dash, linewidth=layer.width)
                if layer.band:
                    spread = 2 * np.sqrt(n)
                    low = np.maximum(n - spread, 0.3)
                    ax.fill_between(k, low, n + spread, where=n > 0, color=INK, alpha=0.15, lw=0)
            ax.set_xscale("log")
            ax.set_yscale("log")
            log_axis(ax.xaxis)
            ax.set_ylim(bottom=0.7)
            ax.set_title(title)
            ax.set_xlabel("k [robust sigmas]")
        axes[0, 0].set_ylabel("pixels above k")
        log_axis(axes[0, 0].yaxis)
        name_layers(fig, drawn)
        return fig

    return picture(
        draw,
        "Pixels of the mean frame above its median by more than k robust sigmas. Band: two "
        "standard errors of counting." + plane_note(measured),
        "Exceedance counts of the hot-pixel tail on logarithmic axes.",
    )
