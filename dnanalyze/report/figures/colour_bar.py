"""The one colour bar that several maps share."""

from __future__ import annotations

from typing import Any

from dnanalyze.report.figures.style import Cell, log_axis


def draw_bar(
    ax: Any, label: str, low: float, high: float, cmap: str = "cividis", log: bool = False
) -> Any:
    """A vertical bar that fills the axes."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm, Normalize

    norm = (LogNorm if log else Normalize)(low, high)
    bar = ax.figure.colorbar(ScalarMappable(norm, cmap), cax=ax)
    if log:
        log_axis(ax.yaxis)
    bar.set_label(label)
    bar.outline.set_visible(False)
    return ax


def bar_cell(
    label: str,
    low: float,
    high: float,
    cmap: str = "cividis",
    height: float = 2.0,
    log: bool = False,
) -> Cell:
    """The bar as a panel of its own beside the maps."""
    return Cell(lambda ax: draw_bar(ax, label, low, high, cmap, log), 0.85, height)
