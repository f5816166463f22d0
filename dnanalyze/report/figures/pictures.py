"""Pictures of a page: panels that flow into one column on a telephone, one legend, one caption."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from dnanalyze.errors import InputError
from dnanalyze.report.figures.png_palette import lighter
from dnanalyze.report.figures.rc_params import styled
from dnanalyze.report.figures.svg import svg_of
from dnanalyze.report.figures.ticks import log_axis

WIDTH = 10.4  # inch: the width of the page's column
Draw = Callable[[], Any]  # a figure function with its arguments; None where nothing is to be seen


@dataclass(frozen=True)
class Panel:
    """One drawing.

    Parameters
    ----------
    svg : str
    width : float
        Natural width, inch (96 CSS pixels); the page shrinks it to seven tenths at most.
    """

    svg: str
    width: float = WIDTH


@dataclass(frozen=True)
class Key:
    """An entry of the legend: how a line, or a marker alone, looks, and its name."""

    label: str
    colour: str
    dash: tuple[float, ...] | None = ()
    width: float = 1.3
    marker: str = ""
    filled: bool = True


@dataclass(frozen=True)
class Cell:
    """A panel to be drawn.

    Parameters
    ----------
    draw : callable
        Draws into the matplotlib axes that it is given; what draws nothing is left out.
    width, height : float
        Inch.
    share : str
        Panels with the same word here have the same vertical limits.
    title : str
        Above it; by default the one that ``draw`` sets.
    """

    draw: Callable[[Any], Any]
    width: float = 3.35
    height: float = 2.35
    share: str = ""
    title: str = ""

    def drawn_on(self, ax: Any) -> None:
        """Draw into these axes."""
        self.draw(ax)
        if self.title:
            ax.set_title(self.title)


@dataclass(frozen=True)
class Picture:
    """Panels ready for a page, their legend, a caption, and words for who cannot see them.

    ``cells`` draw the same panels again, into a user's own axes: see `plotted`.
    """

    panels: tuple[Panel, ...]
    caption: str
    alt: str
    legend: tuple[Key, ...] = ()
    title: str = ""
    cells: tuple[Cell, ...] = ()


def panels(cells: Sequence[Cell], caption: str, alt: str, title: str = "") -> Picture | None:
    """The panels that have something to show; None where none has."""
    with styled():
        made = [(cell, *_drawn(cell)) for cell in cells]
        made = [m for m in made if m[2].has_data()]
        if not made:
            return None
        kept, axes = tuple(m[0] for m in made), [m[2] for m in made]
        _share(kept, axes)
        drawn = tuple(Panel(lighter(svg_of(fig)), cell.width) for cell, fig, _ in made)
        return Picture(drawn, caption, alt, legend_of(axes), title, kept)


def plotted(shown: Picture, ax: Any = None) -> Any:
    """The panels of a picture on a user's axes, or on a new figure of pyplot.

    Parameters
    ----------
    shown : Picture
    ax : matplotlib.axes.Axes, optional
        Several panels divide its place among them.

    Returns
    -------
    matplotlib.axes.Axes or numpy.ndarray of Axes
        An array where there are several panels.

    Raises
    ------
    InputError
        There are several panels, and ``ax`` is not part of a grid.
    """
    import numpy as np

    with styled():
        axes = _places(shown.cells, ax)
        for cell, own in zip(shown.cells, axes, strict=True):
            cell.drawn_on(own)
        _share(shown.cells, axes)
        if shown.legend:
            axes[0].legend()
    return axes[0] if len(axes) == 1 else np.array(axes)


def _places(cells: Sequence[Cell], ax: Any) -> list[Any]:
    """Axes for so many panels, up to three in a row."""
    columns = min(len(cells), 3)
    rows = -(-len(cells) // columns)
    if ax is None:
        from matplotlib import pyplot

        size = (columns * max(c.width for c in cells), rows * max(c.height for c in cells))
        grid = pyplot.figure(figsize=size, layout="constrained").add_gridspec(rows, columns)
    elif len(cells) == 1:
        return [ax]
    else:
        place = ax.get_subplotspec()
        if place is None:
            raise InputError(
                "ax: this kind has several panels; give axes of a grid (plt.subplots), or none"
            )
        ax.set_axis_off()
        grid = place.subgridspec(rows, columns)
    fig: Any = grid.figure if ax is None else ax.figure
    return [fig.add_subplot(grid[n // columns, n % columns]) for n in range(len(cells))]


def _share(cells: Sequence[Cell], axes: Sequence[Any]) -> None:
    """The same vertical limits for the panels that share them."""
    for group in {cell.share for cell in cells if cell.share}:
        same = [ax for cell, ax in zip(cells, axes, strict=True) if cell.share == group]
        low, high = zip(*(ax.get_ylim() for ax in same), strict=True)
        for ax in same:
            ax.set_ylim(min(low), max(high))
            if ax.get_yscale() == "log":
                log_axis(ax.yaxis)


def _drawn(cell: Cell) -> tuple[Any, Any]:
    fig = _figure(cell.width, cell.height)
    ax = fig.subplots()
    cell.drawn_on(ax)
    return fig, ax


def _figure(width: float, height: float) -> Any:
    from matplotlib.figure import Figure

    fig = Figure(figsize=(width, height), layout="constrained")
    engine: Any = fig.get_layout_engine()
    engine.set(w_pad=0.05, h_pad=0.05, wspace=0.02, hspace=0.04)
    return fig


def legend_of(drawn: Sequence[Any]) -> tuple[Key, ...]:
    """What the axes have labelled, each label once; nothing to tell apart needs no legend."""
    from matplotlib.colors import to_hex
    from matplotlib.lines import Line2D

    found: dict[str, Key] = {}
    for ax in drawn:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            line = handle if isinstance(handle, Line2D) else handle[0]
            mark = line.get_marker() not in ("None", None, "", " ")
            dash = _dash(line)
            found.setdefault(
                label,
                Key(
                    label,
                    to_hex(line.get_color()),
                    dash,
                    line.get_linewidth(),
                    str(line.get_marker()) if mark and dash is None else "",
                    to_hex(line.get_markerfacecolor()) == to_hex(line.get_color()),
                ),
            )
    return tuple(found.values()) if len(found) > 1 else ()


def _dash(line: Any) -> tuple[float, ...] | None:
    """Lengths of dashes and gaps in line widths; none where solid, None where there is no line."""
    if line.get_linestyle() in ("None", "", " "):
        return None
    _, lengths = line._unscaled_dash_pattern  # matplotlib has no public way to ask
    return tuple(lengths or ())
