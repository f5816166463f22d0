"""The histogram of the values at one operating point, measured and of the models."""

from __future__ import annotations

import html

import panel as pn

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.workbench import curves
from dnanalyze.workbench.curves import Address
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.figure import curves_of, layers
from dnanalyze.workbench.page.plot import CurvePlot
from dnanalyze.workbench.page.points import labelled, unbroken
from dnanalyze.workbench.page.style import inner

NAME = "frame_skewness"  # a statistic whose curve is the histogram


class Histogram:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        self._address: Address | None = None
        self.plot = CurvePlot(context.palette, "histogram")
        self.title = pn.pane.HTML(
            "", stylesheets=[inner(context.palette)], margin=(2, 0, 0, 0),
            sizing_mode="stretch_width",
        )  # fmt: skip
        self.drawn = pn.Column(
            pn.pane.Bokeh(self.plot.figure, sizing_mode="stretch_both", margin=0),
            pn.pane.Bokeh(self.plot.residuals, sizing_mode="stretch_width", margin=0),
            sizing_mode="stretch_both", margin=0, styles={"min-height": "0"}, visible=False,
        )  # fmt: skip
        self.view = pn.Column(
            self.title, self.drawn, sizing_mode="stretch_both", margin=0,
            styles={"min-height": "0"},
        )  # fmt: skip
        context.listeners.append(self.update)

    def chosen(self, point: OperatingPoint, plane: str) -> None:
        """Draw another operating point or colour plane."""
        self._address = Address(NAME, point, plane.rstrip("0123456789"))
        self._draw()

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what in ("evaluation", "preview", "candidate"):
            self._draw()

    def _draw(self) -> None:
        session, address = self.context.session, self._address
        if address is None:
            return
        where = html.escape(unbroken(labelled(address.point, address.plane)))
        if session.problem is None:
            self.title.object = f"<span class=loading>histogram at {where} …</span>"
            return
        found = layers(self.context)
        measured = found["measured"][0]
        planes = [s.plane for s in measured.settings if s.point == address.point]
        if planes and address.plane not in planes:  # a mosaic has no histogram over all planes
            address = Address(NAME, address.point, planes[0])
            where = html.escape(unbroken(labelled(address.point, address.plane)))
        drawn = curves_of(found, address)
        text = f"<b>Pixel values</b> <span class=quiet>{where}, half of the field</span>"
        if "measured" not in drawn:
            text = f"<span class=quiet>no histogram at {where}: it is not compared</span>"
        if self.title.object != text:
            self.title.object = text
        axes = curves.axes(address, measured)
        assert axes is not None
        self.plot.show(axes, [], drawn, address)
        self.drawn.visible = True
