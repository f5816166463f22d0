"""Radial spectra of all operating points on one axis: Figure 2 of Wang 2025."""

from __future__ import annotations

from typing import Any

import numpy as np
import panel as pn
from bokeh.models import ColumnDataSource
from matplotlib.colors import LinearSegmentedColormap, to_hex

from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.report.figures.spectrum import names_of
from dnanalyze.report.figures.style import chosen, has, labels
from dnanalyze.report.figures.wang_2025 import MAX_POINTS, WARMTH
from dnanalyze.report.rivals import FILTERS
from dnanalyze.workbench import curves
from dnanalyze.workbench.curves import Address
from dnanalyze.workbench.evaluation import Evaluation
from dnanalyze.workbench.frames import Kind, View
from dnanalyze.workbench.page.background import Latest
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.figure import layers
from dnanalyze.workbench.page.log_axis import log_formatter, log_ticker
from dnanalyze.workbench.page.point_figure import OF, PART
from dnanalyze.workbench.page.style import inner, plain_figure

RAW = "without its filters"
DASHES = {"measured": ("solid", 1.8), "model": ("6 3", 1.5), RAW: ("1 3", 1.8)}
Layers = dict[str, tuple[Statistics, curves.Change | None]]
WIDTH = 54  # letters of a line of the legend
COLUMNS = "xs", "ys", "colour", "label"


class AllSpectra:
    """The pane; drawn where it is seen alone.

    Parameters
    ----------
    context : Context
    """

    def __init__(self, context: Context) -> None:
        self.context = context
        self._kind: Kind = "mean"
        self._raw: Evaluation | None = None
        self._latest = Latest(context.back)
        p = context.palette
        self.title = pn.pane.HTML(
            "", stylesheets=[inner(p)], margin=(2, 0, 0, 0), sizing_mode="stretch_width"
        )
        self.sources = {
            n: ColumnDataSource({k: [] for k in COLUMNS}, name=f"all spectra of {n}")
            for n in DASHES
        }
        self.figure = made = plain_figure(
            p, sizing_mode="stretch_both", tools="pan,wheel_zoom,box_zoom,reset",
            x_axis_type="log", y_axis_type="log", name="all spectra",
            x_axis_label="spatial frequency [cycles/pixel]", y_axis_label="power [DN²]",
        )  # fmt: skip
        for axis, grid in ((made.xaxis[0], made.xgrid[0]), (made.yaxis[0], made.ygrid[0])):
            axis.ticker = grid.ticker = log_ticker(sparse=axis is made.yaxis[0])
            axis.formatter = log_formatter()
        for name, (dash, width) in DASHES.items():
            told = {"legend_field": "label"} if name == "measured" else {}
            made.multi_line(
                "xs", "ys", source=self.sources[name], line_color="colour", line_dash=dash,
                line_width=width, **told,
            )  # fmt: skip
        self.legend = legend = made.legend[0]
        legend.update(
            label_text_font_size="10px", label_text_color=p.ink, background_fill_color=p.card,
            border_line_color=None, padding=1, margin=1, spacing=6, orientation="horizontal",
            glyph_width=12,
        )  # fmt: skip
        made.add_layout(legend, "above")
        self.view = pn.Column(
            self.title, pn.pane.Bokeh(made, sizing_mode="stretch_both", margin=0),
            sizing_mode="stretch_both", margin=0,
            styles={"min-height": "0"},
        )  # fmt: skip
        context.listeners.append(self.update)

    def chosen(self, view: View, point: OperatingPoint) -> None:
        """Draw the spectra of another kind of image."""
        self._kind = view.kind
        self.draw()

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what in ("evaluation", "preview"):
            self.draw()

    def draw(self) -> None:
        """Draw the spectra, where the pane is seen."""
        session, shown = self.context.session, self.context.shown
        if not self.view.visible:
            return
        if session.problem is None:
            self.title.object = "<span class=loading>spectra of all operating points …</span>"
            return
        self._take_filters_out()
        found = layers(self.context)
        if self._raw is not None:
            found[RAW] = self._raw.simulated, self._raw.change
        measured = found["measured"][0]
        kind = self._kind
        points = chosen(measured, MAX_POINTS, has(*names_of(PART[kind], True)))
        if not points:  # a single frame at each
            kind = "frame"
            points = chosen(measured, MAX_POINTS)
        warmth = LinearSegmentedColormap.from_list("warmth", WARMTH)
        tones = [to_hex(c) for c in warmth(np.linspace(0, 1, max(len(points), 2)))]
        drawn = {"measured": "measured", "model": "present model", RAW: RAW}
        names = labels(points)
        self.legend.ncols = max(1, WIDTH // (max(map(len, names), default=1) + 4))
        for name, layer in drawn.items():
            data: dict[str, list[Any]] = {k: [] for k in COLUMNS}
            for setting, tone, label in zip(points, tones, names, strict=False):
                address = curves.whole_spectrum(PART[kind], setting.point, setting.plane)
                c = _curve(found, layer, address)
                if c is not None:
                    for key, value in zip(COLUMNS, (c.x, c.y, tone, label), strict=True):
                        data[key].append(value)
            self.sources[name].data = data
        lines = "<b>—</b> measured" + (" <b>- -</b> model" if shown is not None else "")
        lines += f" <b>···</b> model {RAW}" if self._raw is not None else ""
        text = f"<b>Radial spectra of {OF[kind]}</b> <span class=quiet>{lines}</span>"
        if self.title.object != text:
            self.title.object = text

    def _take_filters_out(self) -> None:
        """Ask for the present model without its filters, where it has any."""
        session, shown = self.context.session, self.context.shown
        model = None if shown is None else shown.model
        there = [n for n in FILTERS if model is not None and model.get(n) is not None]
        if model is None or not there:
            self._raw = None
            return
        for name in there:
            model = model.without(name)
        if self._raw is not None and self._raw.model == model:
            return
        raw = model

        def show(found: Evaluation) -> None:
            self._raw = found
            self.draw()

        self._latest.ask(lambda: session.preview(raw), show, lambda error: session.tell(str(error)))


def _curve(found: Layers, layer: str, address: Address) -> curves.Curve | None:
    if layer not in found:
        return None
    statistics, change = found[layer]
    return curves.curve(statistics, address, found["measured"][0], change)
