"""A pixel against the largest of its neighbours: the scatter in which defect correction shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.report.figures.style import GAUSSIAN, Picture, figure, picture

CELLS = 120
FARTHEST = 60.0  # robust sigmas


def largest_neighbour(frame: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inner pixels and the largest of the 8 neighbours of each, same unit, same shape."""
    from scipy.ndimage import maximum_filter

    ring = np.ones((3, 3), bool)
    ring[1, 1] = False
    around = maximum_filter(frame, footprint=ring)
    return frame[1:-1, 1:-1], around[1:-1, 1:-1]


def scatter(frames: Sequence[tuple[str, np.ndarray]]) -> Picture | None:
    """One panel a frame.

    Parameters
    ----------
    frames : sequence of (str, ndarray)
        Title and one frame (one colour plane), DN.
    """
    if not frames:
        return None

    def draw() -> Any:
        from matplotlib.colors import LogNorm

        fig, axes = figure(1, len(frames), 3.9, width=min(10.4, 4.4 * len(frames) + 0.8))
        image = None
        for ax, (title, frame) in zip(axes[0], frames, strict=True):
            y, x, top, step = _scaled(frame)
            edges = np.arange(
                -5 - step / 2, top + step, step * max(1, round((top + 5) / CELLS / step))
            )
            counts, _, _ = np.histogram2d(x, y, bins=[edges, edges])
            shown = np.ma.masked_less(counts.T, 1)
            image = ax.pcolormesh(
                edges, edges, shown, norm=LogNorm(1, 1e4), cmap="cividis", rasterized=True
            )
            ax.plot([-5, top], [-5, top], color=GAUSSIAN, linewidth=0.9)
            ax.annotate("equal", (top, top), (-4, -12), textcoords="offset points", ha="right",
                        color=GAUSSIAN, fontsize=7.2)  # fmt: skip
            ax.set_title(title)
            ax.set_xlabel("largest of 8 neighbours [robust sigmas]")
            ax.set_aspect("equal")
            ax.set_xlim(-5, top)
            ax.set_ylim(-5, top)
        axes[0, 0].set_ylabel("pixel [robust sigmas]")
        bar = fig.colorbar(image, ax=list(axes[0]), shrink=0.8, aspect=24, pad=0.02)
        bar.set_label("pixels")
        bar.outline.set_visible(False)
        return fig

    return picture(
        draw,
        "Each pixel of one frame against the largest of its eight neighbours (of its own colour). "
        "In an unfiltered frame hot pixels form a vertical arm at the left, far above the line of "
        "equality. Where the arm is missing, or cut off along a line, a filter has removed them.",
        "Scatter of pixels against the largest of their neighbours.",
    )


def _scaled(frame: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Pixel and neighbours' maximum above the median, the axes' end, one code; robust sigmas."""
    y, x = largest_neighbour(frame.astype(float))
    middle = np.median(y)
    sigma = max(float(np.subtract(*np.percentile(y, [75, 25]))) / 1.349, 0.3)
    y, x = (y.ravel() - middle) / sigma, (x.ravel() - middle) / sigma
    top = float(np.clip(1.1 * np.percentile(y, 99.995), 8, FARTHEST))
    step = 1 / sigma if np.issubdtype(frame.dtype, np.integer) else (top + 5) / CELLS
    return np.clip(y, -5, top), np.clip(x, -5, top), top, step
