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


def bar_below(ax: Any, image: Any, ends: tuple[float, float], aspect: float, margin: float) -> None:
    """A horizontal bar in DN below a map without ticks.

    No label stands within ``margin``, a share of the bar, of its ends: it would make its map
    smaller than the others.
    """
    from matplotlib.ticker import MaxNLocator

    ax.grid(visible=False)
    ax.set(xticks=[], yticks=[])
    bar = ax.figure.colorbar(image, ax=ax, orientation="horizontal", pad=0.03, aspect=aspect)
    bar.set_label("DN")
    bar.outline.set_visible(False)
    bar.ax.tick_params(labelsize=7, length=2)
    inside = ends[1] - ends[0]
    ticks = MaxNLocator(4).tick_values(*ends)
    bar.set_ticks([t for t in ticks if margin < (t - ends[0]) / inside < 1 - margin])
