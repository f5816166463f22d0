"""The frame mean from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.report.figures.style import (
    Cell,
    Layer,
    Picture,
    chosen,
    curve,
    labels,
    panels,
    plane_note,
)


def draw_frame_means(ax: Any, drawn: Sequence[Layer], setting: Any) -> Any:
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


def frame_means(drawn: Sequence[Layer], most: int = 3) -> Picture | None:
    """One panel an operating point."""
    measured = drawn[0].statistics
    settings = chosen(measured, most, lambda s: _means(s) is not None)

    def cell(setting: Any, title: str) -> Cell:
        def draw(ax: Any) -> None:
            draw_frame_means(ax, drawn, setting).set_title(title)

        return Cell(draw, height=2.0)

    return panels(
        [cell(s, t) for s, t in zip(settings, labels(settings), strict=True)],
        "Mean of each frame minus the mean of all frames of the operating point, in the order of "
        "capture; hot pixels are clipped." + plane_note(measured, settings),
        "Frame means in the order in which the frames were taken.",
    )


def _means(setting: Any) -> np.ndarray | None:
    found = curve(setting, "frame_means")
    if found is None or found[0].size < 2:
        return None
    return found[0] - found[0].mean()
