"""A plot of curves by layer, for one kind of axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from bokeh.models import ColumnDataSource, CustomJS, FixedTicker, Whisker

from dnanalyze.workbench.curves import Address, Axes
from dnanalyze.workbench.page.points import without_shared
from dnanalyze.workbench.page.style import Palette, hover, plain_figure

LAYERS = ("measured", "Wang 2025 model", "present model", "candidate")
EMPTY: dict[str, list[float]] = {"x": [], "y": [], "low": [], "high": []}


@dataclass(frozen=True)
class Kind:
    """What cannot be changed on a plot: the scales, and whether the abscissa has names."""

    log_x: bool
    log_y: bool
    named: bool


class CurvePlot:
    """A Bokeh figure of the layers.

    Parameters
    ----------
    palette : Palette
    kind : Kind
    sources : mapping
        Data of each layer: x, y, and the ends of the error band, low and high.
    """

    def __init__(self, palette: Palette, kind: Kind, sources: dict[str, ColumnDataSource]) -> None:
        p = palette
        self.kind = kind
        self.figure = made = plain_figure(
            p, sizing_mode="stretch_both", tools="pan,wheel_zoom,box_zoom,reset",
            x_axis_label=" ", y_axis_label=" ",
            x_axis_type="log" if kind.log_x else "linear",
            y_axis_type="log" if kind.log_y else "linear",
        )  # fmt: skip
        looks = {
            "measured": (p.ink, "solid", 1.6),
            "Wang 2025 model": (p.wang, "8 3", 1.8),
            "present model": (p.present, "solid", 2.2),
            "candidate": (p.candidate, "2 2", 2.4),
        }
        measured = sources["measured"]
        if kind.named:
            made.xaxis.ticker = FixedTicker(ticks=[])
            made.add_layout(
                Whisker(source=measured, base="x", upper="high", lower="low", line_color=p.ink)
            )
        else:
            made.varea(
                x="x", y1="low", y2="high", source=measured, fill_color=p.ink, fill_alpha=0.16
            )
        drawn = []
        for name, (colour, dash, width) in looks.items():
            drawn.append(
                made.line("x", "y", source=sources[name], color=colour, line_dash=dash,
                          line_width=width, legend_label=name, name=name)
            )  # fmt: skip
            if kind.named:
                made.scatter("x", "y", source=sources[name], color=colour, size=6)
        self._hover = hover(p, drawn, ("", "$name"), mode="mouse")
        made.add_tools(self._hover)
        _legend(made, p)
        made.js_on_change("tags", CustomJS(code="cb_obj.reset.emit()"))  # forget the zoom

    def label(self, axes: Axes, labels: list[str], address: Address) -> None:
        """Name the axes; a statistic that was not shown before is shown whole."""
        made = self.figure
        if self.kind.named:
            made.xaxis.ticker.ticks = list(range(len(labels)))
            made.xaxis.major_label_overrides = dict(enumerate(without_shared(labels)))
        if (made.xaxis[0].axis_label, made.yaxis[0].axis_label) != (axes.x, axes.y):
            made.xaxis.axis_label, made.yaxis.axis_label = axes.x, axes.y
            self._hover.tooltips = [
                ("", "$name"),
                (axes.x.split(" [")[0], "@x{0.0000}"),
                (axes.y.split(" [")[0], "@y{0.000e}" if axes.log_y else "@y{0.000}"),
            ]
        for item in made.legend[0].items:  # an empty curve has no line in the legend
            (line,) = item.renderers
            item.visible = bool(len(line.data_source.data["x"]))
        shown = [str(address)]
        if made.tags != shown:
            made.tags = shown


def _legend(made: Any, p: Palette) -> None:
    """Above the plot, in one row."""
    legend = made.legend[0]
    legend.label_text_font_size = "10px"
    legend.label_text_color = p.ink
    legend.background_fill_color = p.card
    legend.background_fill_alpha = 0.75
    legend.border_line_color = None
    legend.padding = legend.margin = 3
    legend.spacing = 10
    legend.orientation = "horizontal"
    made.add_layout(legend, "above")
