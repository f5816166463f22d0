"""A pixel over the largest of its neighbours: the scatter in which defect correction shows."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from dnanalyze.report.figures.colour_bar import bar_cell
from dnanalyze.report.figures.style import GAUSSIAN, Cell, Picture, panels

CELLS = 120
FARTHEST = 60.0  # robust standard deviations
BRIGHT_END = 1e4  # pixels in a cell at the bright end of the colours
EQUAL = "pixel = neighbour"


def largest_neighbour(frame: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inner pixels and the largest of the 8 neighbours of each, same unit, same shape."""
    from scipy.ndimage import maximum_filter

    ring = np.ones((3, 3), bool)
    ring[1, 1] = False
    around = maximum_filter(frame, footprint=ring)
    return frame[1:-1, 1:-1], around[1:-1, 1:-1]


def draw_neighbours(ax: Any, frame: np.ndarray) -> Any:
    """Density of the pixels over (largest of 8 neighbours, pixel), robust standard deviations.

    Parameters
    ----------
    ax : matplotlib axes
    frame : ndarray
        One frame (one colour plane), DN.
    """
    from matplotlib.colors import LogNorm

    y, x, top, step = _scaled(frame)
    edges = np.arange(-5 - step / 2, top + step, step * max(1, round((top + 5) / CELLS / step)))
    counts, _, _ = np.histogram2d(x, y, bins=[edges, edges])
    ax.grid(visible=False)
    shown = np.ma.masked_less(counts.T, 1)
    ax.imshow(
        shown, norm=LogNorm(1, BRIGHT_END), cmap="cividis", origin="lower", aspect="equal",
        extent=(edges[0], edges[-1], edges[0], edges[-1]),
    )  # fmt: skip
    ax.plot([-5, top], [-5, top], color=GAUSSIAN, linewidth=0.9, label=EQUAL)
    ax.set_xlabel("largest of 8 neighbours [robust σ]")
    ax.set_ylabel("pixel [robust σ]")
    ax.set_xlim(-5, top)
    ax.set_ylim(-5, top)
    return ax


def scatter(frames: Sequence[tuple[str, np.ndarray]]) -> Picture | None:
    """One panel a frame.

    Parameters
    ----------
    frames : sequence of (str, ndarray)
        Title and one frame (one colour plane), DN.
    """
    if not frames:
        return None
    cells = [
        Cell(partial(draw_neighbours, frame=frame), 3.6, 3.6, title=title)
        for title, frame in frames
    ]
    return panels(
        [*cells, bar_cell("pixels", 1, BRIGHT_END, height=3.3, log=True)],
        "Each pixel of one frame over the largest of its eight neighbours (of its own colour), "
        "above the median, in robust standard deviations. Orange line: pixel and neighbour are "
        "equal. In an unfiltered frame hot pixels form a vertical arm at the left, far above that "
        "line. A missing arm, or one that ends along a line, shows a filter.",
        "Scatter of pixels over the largest of their neighbours.",
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
