"""The figure of a statistic: measured with its error band, and the models."""

from __future__ import annotations

import html

import numpy as np
import pandas as pd
import panel as pn
from matplotlib.figure import Figure

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.digits import symbol
from dnanalyze.workbench import curves
from dnanalyze.workbench.curves import Address
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.downloads import downloads
from dnanalyze.workbench.page.plot import CurvePlot
from dnanalyze.workbench.page.points import labelled, unbroken, without_shared
from dnanalyze.workbench.page.style import inner
from dnanalyze.workbench.page.terms import with_term

TITLE = 35  # screen pixels of two lines: a figure that moves leaves its old image behind


class CurveFigure:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        style = [inner(context.palette)]
        self.title = pn.pane.HTML(
            "", css_classes=["statistic"], stylesheets=style, margin=0, min_height=TITLE,
            sizing_mode="stretch_width",
        )  # fmt: skip
        self.what = pn.widgets.RadioButtonGroup(
            options=["curve", "all points"], value="curve", stylesheets=style,
            margin=(0, 6, 0, 6), width=130,
        )  # fmt: skip
        self.what.param.watch(lambda _: context.later("curve"), "value")
        self.plot = CurvePlot(context.palette)
        self.view = pn.Column(
            pn.Row(
                self.title, self.what,
                *downloads("statistic", self._table, self._drawn, style, "the curves shown"),
                margin=(4, 0, 0, 0), sizing_mode="stretch_width",
            ),
            pn.pane.Bokeh(self.plot.figure, sizing_mode="stretch_both", margin=0, min_height=104),
            pn.pane.Bokeh(self.plot.residuals, sizing_mode="stretch_width", margin=0),
            sizing_mode="stretch_both",
            margin=0,
            styles={"min-height": "0"},
            visible=False,
        )  # fmt: skip
        context.listeners.append(self.update)

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what in ("address", "evaluation", "preview", "candidate", "curve"):
            self._draw()

    def _curves(self) -> tuple[curves.Axes, list[str], dict[str, curves.Curve]]:
        """Axes, labels of the abscissa (none for a continuous one), curves by layer."""
        address = self.context.address
        assert address is not None
        found = layers(self.context)
        measured = found["measured"][0]
        axes = curves.axes(address, measured)
        if axes is not None and self.what.value == "curve":
            drawn = curves_of(found, address)
            if "measured" in drawn:
                return axes, [], drawn
        info = infos()[address.name]
        unit = f"value [{symbol(info.unit)}]" if symbol(info.unit) else "value"
        both = {k: curves.over_points(s, address, measured, c) for k, (s, c) in found.items()}
        labels, made = both["measured"][0], {k: c for k, (_, c) in both.items()}
        ends = np.concatenate([c.y for c in made.values()]) if made else np.ones(1)
        log = bool(np.all(ends > 0) and ends.max() > 20 * ends.min())
        return curves.Axes("operating point", unit, False, log), labels, made

    def _draw(self) -> None:
        session, address = self.context.session, self.context.address
        if session.problem is None or address is None:
            return
        self.view.visible = True
        axes, labels, found = self._curves()
        self.what.visible = not labels or self.what.value != "curve"  # else it has no curve
        where = unbroken(labelled(address.point, address.plane))
        info = infos()[address.name]
        self.title.object = (
            f"<b>{with_term(info.title)}</b> <span class=quiet>{html.escape(where)}</span>"
        )
        measured = session.problem.measured[1]
        marks = [] if labels else curves.marks(address, measured)
        band = None if labels else curves.band(address)
        self.plot.show(axes, labels, found, (address, bool(labels)), marks, band)

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
        return printed(axes, labels, found)


def layers(context: Context) -> dict[str, tuple[Statistics, curves.Change | None]]:
    """Statistics of each layer, with the change that a preview makes to them."""
    session = context.session
    assert session.problem is not None
    models = {
        "Wang 2025 model": session.baseline,
        "present model": context.shown,
        "candidate": context.candidate[1] if context.candidate else None,
    }
    wang, present = session.baseline, context.shown
    if wang is not None and present is not None and wang.model == present.model:
        del models["Wang 2025 model"]  # its line would lie below the present one
    found = {k: (e.simulated, e.change) for k, e in models.items() if e is not None}
    return {"measured": (session.problem.measured[1], None), **found}


def curves_of(
    found: dict[str, tuple[Statistics, curves.Change | None]], address: Address
) -> dict[str, curves.Curve]:
    """The curves of a statistic's family by layer, where a layer has one."""
    measured = found["measured"][0]
    drawn = {k: curves.curve(s, address, measured, c) for k, (s, c) in found.items()}
    return {k: v for k, v in drawn.items() if v is not None}


def printed(axes: curves.Axes, labels: list[str], found: dict[str, curves.Curve]) -> Figure:
    """The curves for print."""
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
