"""The figure of a statistic: measured with its error band, and the models."""

from __future__ import annotations

import html
import io
from typing import Any

import numpy as np
import pandas as pd
import panel as pn
from bokeh.models import ColumnDataSource, FixedTicker, Whisker
from matplotlib.figure import Figure

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.digits import symbol
from dnanalyze.workbench import curves
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.points import labelled, without_shared
from dnanalyze.workbench.page.style import hover, inner, plain_figure


class CurveFigure:
    """The pane."""

    LAYERS = ("measured", "Wang 2025 model", "present model", "candidate")

    def __init__(self, context: Context) -> None:
        self.context = context
        p = context.palette
        style = [inner(p)]
        self.title = pn.pane.HTML(
            "",
            css_classes=["statistic"],
            stylesheets=style,
            margin=(4, 0, 0, 0),
            sizing_mode="stretch_width",
        )
        self.what = pn.widgets.RadioButtonGroup(
            options=["curve", "all points"], value="curve", stylesheets=style,
            margin=0, width=130,
        )  # fmt: skip
        self.csv = pn.widgets.FileDownload(
            callback=self._csv, filename="figure.csv", label="CSV", button_type="default",
            stylesheets=style, margin=0, width=48,
        )  # fmt: skip
        self.png = pn.widgets.FileDownload(
            callback=lambda: self._drawn("png"), filename="figure.png", label="PNG",
            button_type="default", stylesheets=style, margin=0, width=48,
        )  # fmt: skip
        self.svg = pn.widgets.FileDownload(
            callback=lambda: self._drawn("svg"), filename="figure.svg", label="SVG",
            button_type="default", stylesheets=style, margin=0, width=48,
        )  # fmt: skip
        self.what.param.watch(lambda _: self._draw(), "value")
        self._sources = {
            name: ColumnDataSource({"x": [], "y": [], "low": [], "high": []})
            for name in self.LAYERS
        }
        self._kind: tuple[Any, ...] = ()
        self.pane = pn.pane.Bokeh(sizing_mode="stretch_both", margin=0, min_height=150)
        self.view = pn.Column(
            pn.Row(self.title, margin=0, sizing_mode="stretch_width"),
            pn.Row(
                self.what, pn.layout.HSpacer(), self.csv, self.png, self.svg,
                margin=0, sizing_mode="stretch_width",
            ),
            self.pane,
            sizing_mode="stretch_both",
            margin=0,
        )  # fmt: skip
        context.listeners.append(self.update)

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what in ("address", "evaluation", "preview", "candidate"):
            self._draw()

    def _statistics(self) -> dict[str, Any]:
        context, session = self.context, self.context.session
        assert session.bench is not None
        shown = context.shown
        return {
            "measured": session.bench.measured[1],
            "Wang 2025 model": session.baseline.simulated if session.baseline else None,
            "present model": shown.simulated if shown else None,
            "candidate": context.candidate[1] if context.candidate else None,
        }

    def _curves(self) -> tuple[curves.Axes, list[str], dict[str, curves.Curve]]:
        """Axes, labels of the abscissa (none for a continuous one), curves by layer."""
        address = self.context.address
        assert address is not None
        layers = {k: v for k, v in self._statistics().items() if v is not None}
        axes = curves.axes(address)
        if axes is not None and self.what.value == "curve":
            measured = layers["measured"]
            found = {k: curves.curve(v, address, measured) for k, v in layers.items()}
            if found["measured"] is not None:
                return axes, [], {k: v for k, v in found.items() if v is not None}
        info = infos()[address.name]
        unit = f"value [{symbol(info.unit)}]" if symbol(info.unit) else "value"
        both = {k: curves.over_points(v, address, layers["measured"]) for k, v in layers.items()}
        labels, made = both["measured"][0], {k: c for k, (_, c) in both.items()}
        ends = np.concatenate([c.y for c in made.values()]) if made else np.ones(1)
        log = bool(np.all(ends > 0) and ends.max() > 20 * ends.min())
        return curves.Axes("operating point", unit, False, log), labels, made

    def _draw(self) -> None:
        session, address = self.context.session, self.context.address
        if session.bench is None or address is None:
            return
        axes, labels, found = self._curves()
        where = labelled(address.point, address.plane)
        self.title.object = (
            "<div style='white-space:nowrap;overflow:hidden;text-overflow:ellipsis'>"
            f"<b>{infos()[address.name].title}</b> "
            f"<span class=quiet>{html.escape(where)}</span></div>"
        )
        kind = axes, tuple(labels)
        if kind != self._kind:
            self._kind = kind
            self.pane.object = self._make(axes, labels)
        for name, source in self._sources.items():
            c = found.get(name)
            source.data = (
                {"x": [], "y": [], "low": [], "high": []}
                if c is None
                else {"x": c.x, "y": c.y, "low": c.low, "high": c.high}
            )

    def _make(self, axes: curves.Axes, labels: list[str]) -> Any:
        p = self.context.palette
        made = plain_figure(
            p, sizing_mode="stretch_both", x_axis_label=axes.x, y_axis_label=axes.y,
            x_axis_type="log" if axes.log_x else "linear",
            y_axis_type="log" if axes.log_y else "linear", tools="pan,wheel_zoom,box_zoom,reset",
        )  # fmt: skip
        looks = {
            "measured": (p.ink, "solid", 1.6),
            "Wang 2025 model": (p.wang, "8 3", 1.8),
            "present model": (p.present, "solid", 2.2),
            "candidate": (p.candidate, "2 2", 2.4),
        }
        drawn = []
        if labels:
            made.xaxis.ticker = FixedTicker(ticks=list(range(len(labels))))
            made.xaxis.major_label_overrides = dict(enumerate(without_shared(labels)))
            made.add_layout(
                Whisker(source=self._sources["measured"], base="x", upper="high", lower="low",
                        line_color=p.ink)
            )  # fmt: skip
        else:
            made.varea(x="x", y1="low", y2="high", source=self._sources["measured"],
                       fill_color=p.ink, fill_alpha=0.16)  # fmt: skip
        for name, (colour, dash, width) in looks.items():
            drawn.append(
                made.line("x", "y", source=self._sources[name], color=colour, line_dash=dash,
                          line_width=width, legend_label=name, name=name)
            )  # fmt: skip
            if labels:
                made.scatter("x", "y", source=self._sources[name], color=colour, size=6)
        made.add_tools(
            hover(p, drawn, ("", "$name"), (axes.x.split(" [")[0], "@x{0.0000}"),
                  (axes.y.split(" [")[0], "@y{0.000e}" if axes.log_y else "@y{0.000}"),
                  mode="mouse")
        )  # fmt: skip
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
        return made

    def _csv(self) -> Any:
        axes, labels, found = self._curves()
        tables = []
        for name, c in found.items():
            where = [labels[int(i)] for i in c.x] if labels else c.x
            table = pd.DataFrame({"layer": name, axes.x: where, axes.y: c.y})
            tables.append(table.assign(low=c.low, high=c.high))
        return io.BytesIO(pd.concat(tables).to_csv(index=False).encode())

    def _drawn(self, form: str) -> Any:
        axes, labels, found = self._curves()
        fig = Figure(figsize=(7, 4.2), layout="constrained")
        ax = fig.add_subplot()
        looks = {"measured": ("#16191d", "-"), "Wang 2025 model": ("#b86e00", "--"),
                 "present model": ("#0072b2", "-"), "candidate": ("#b5348f", ":")}  # fmt: skip
        for name, c in found.items():
            colour, dash = looks[name]
            ax.plot(c.x, c.y, dash, color=colour, label=name, marker="o" if labels else None)
            if name == "measured":
                ax.fill_between(c.x, c.low, c.high, color=colour, alpha=0.15, linewidth=0)
        ax.set(xlabel=axes.x, ylabel=axes.y)
        ax.set_xscale("log" if axes.log_x else "linear")
        ax.set_yscale("log" if axes.log_y else "linear")
        if labels:
            ax.set_xticks(range(len(labels)), without_shared(labels))
        ax.legend(frameon=False)
        out = io.BytesIO()
        fig.savefig(out, format=form, dpi=150)
        out.seek(0)
        return out
