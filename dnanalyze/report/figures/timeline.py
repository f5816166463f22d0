"""The frame mean from frame to frame."""

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


def frame_means(drawn: Sequence[Layer], most: int = 5) -> Picture | None:
    """Mean of each frame minus the mean of all."""
    measured = drawn[0].statistics
    settings = [s for s in chosen(measured, most) if _means(s) is not None]
    if not settings:
        return None

    def draw() -> Any:
        fig, axes = figure(1, len(settings), 1.9)
        for ax, setting, title in zip(axes[0], settings, labels(settings), strict=True):
            for layer in drawn:
                y = _means(layer.like(setting))
                if y is not None:
                    ax.plot(
                        np.arange(1, len(y) + 1), y, marker="o", markersize=2.6, color=layer.colour,
                        linestyle=layer.dash, linewidth=layer.width,
                    )  # fmt: skip
            ax.set_title(title)
            ax.set_xlabel("frame")
            ax.xaxis.get_major_locator().set_params(integer=True)
        axes[0, 0].set_ylabel("frame mean [DN]")
        name_layers(fig, drawn)
        return fig

    return picture(
        draw,
        "Mean of each frame minus the mean of all frames of the setting; hot pixels are cut off."
        + plane_note(measured),
        "Frame means in the order in which the frames were taken.",
    )


def _means(setting: Any) -> np.ndarray | None:
    found = curve(setting, "frame_means")
    if found is None or found[0].size < 2:
        return None
    return found[0] - found[0].mean()
