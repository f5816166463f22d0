"""The figure of a statistic: measured with its error band, and the models."""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import panel as pn
from bokeh.models import ColumnDataSource
from matplotlib.figure import Figure

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.digits import symbol
from dnanalyze.workbench import curves
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.downloads import downloads
from dnanalyze.workbench.page.plot import EMPTY, LAYERS, CurvePlot, Kind
from dnanalyze.workbench.page.points import labelled, without_shared
from dnanalyze.workbench.page.style import inner


class CurveFigure:
    """The pane."""

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
        self.what.param.watch(lambda _: self._draw(), "value")
        self._sources = {
            name: ColumnDataSource(dict(EMPTY), name=f"curve of {name}") for name in LAYERS
        }
        self._plots: dict[Kind, tuple[CurvePlot, Any]] = {}
        self.plots = pn.Column(sizing_mode="stretch_both", margin=0, min_height=150)
        self.view = pn.Column(
            pn.Row(self.title, margin=0, sizing_mode="stretch_width"),
            pn.Row(
                self.what, pn.layout.HSpacer(),
                *downloads("statistic", self._table, self._drawn, style, "the curves shown"),
                margin=0, sizing_mode="stretch_width",
            ),
            self.plots,
            sizing_mode="stretch_both",
            margin=0,
        )  # fmt: skip
        context.listeners.append(self.update)

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what in ("address", "evaluation", "preview", "candidate"):
            self._draw()

    def _layers(self) -> dict[str, tuple[Statistics, curves.Change | None]]:
        """Statistics of each layer, with the change that a preview makes to them."""
        context, session = self.context, self.context.session
        assert session.bench is not None
        models = {
            "Wang 2025 model": session.baseline,
            "present model": context.shown,
            "candidate": context.candidate[1] if context.candidate else None,
        }
        found = {k: (e.simulated, e.change) for k, e in models.items() if e is not None}
        return {"measured": (session.bench.measured[1], None), **found}

    def _curves(self) -> tuple[curves.Axes, list[str], dict[str, curves.Curve]]:
        """Axes, labels of the abscissa (none for a continuous one), curves by layer."""
        address = self.context.address
        assert address is not None
        layers = self._layers()
        measured = layers["measured"][0]
        axes = curves.axes(address, measured)
        if axes is not None and self.what.value == "curve":
            found = {k: curves.curve(s, address, measured, c) for k, (s, c) in layers.items()}
            if found["measured"] is not None:
                return axes, [], {k: v for k, v in found.items() if v is not None}
        info = infos()[address.name]
        unit = f"value [{symbol(info.unit)}]" if symbol(info.unit) else "value"
        both = {k: curves.over_points(s, address, measured, c) for k, (s, c) in layers.items()}
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
        for name, source in self._sources.items():
            c = found.get(name)
            data = dict(EMPTY) if c is None else {k: getattr(c, k) for k in EMPTY}
            if not _same(source.data, data):  # a preview changes one layer: the others stay drawn
                source.data = data
        self._plot(axes, labels).label(axes, labels, address)

    def _plot(self, axes: curves.Axes, labels: list[str]) -> CurvePlot:
        """The plot with such axes, alone to be seen; made when first needed.

        A browser keeps the models of a figure that is replaced: figures are reused.
        """
        kind = Kind(axes.log_x, axes.log_y, bool(labels))
        if kind not in self._plots:
            plot = CurvePlot(self.context.palette, kind, self._sources)
            pane = pn.pane.Bokeh(plot.figure, sizing_mode="stretch_both", margin=0)
            self._plots[kind] = plot, pane
            self.plots.append(pane)
        for other, (_, pane) in self._plots.items():
            pane.visible = other == kind
        return self._plots[kind][0]

    def _table(self) -> pd.DataFrame:
        axes, labels, found = self._curves()
        tables = []
        for name, c in found.items():
            where = [labels[int(i)] for i in c.x] if labels else c.x
            table = pd.DataFrame({"layer": name, axes.x: where, axes.y: c.y})
            tables.append(table.assign(low=c.low, high=c.high))
        return pd.concat(tables)

    def _drawn(self) -> Figure:
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
        return fig


def _same(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether two tables of a layer hold the same numbers."""
    return all(np.array_equal(one[k], other[k], equal_nan=True) for k in EMPTY)
