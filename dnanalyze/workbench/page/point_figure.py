"""Curves at the operating point of the images, of captures and models: Figure 1 of Wang 2025."""

from __future__ import annotations

import html
from collections.abc import Callable

import panel as pn

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.workbench import curves
from dnanalyze.workbench.curves import Address
from dnanalyze.workbench.frames import Kind, View
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.figure import curves_of, layers
from dnanalyze.workbench.page.plot import CurvePlot
from dnanalyze.workbench.page.points import labelled, unbroken
from dnanalyze.workbench.page.style import inner

PART: dict[Kind, str] = {"frame": "frame", "mean": "pattern", "temporal noise": "temporal"}
OF: dict[Kind, str] = {
    "frame": "a single frame", "mean": "the DSNU", "temporal noise": "the temporal noise"
}  # fmt: skip
Named = Callable[[Kind], str]
Addressed = Callable[[Kind, OperatingPoint, str], Address]


class PointFigure:
    """The pane.

    Parameters
    ----------
    context : Context
    name : str
        Of the plot.
    address : callable
        The curve at an operating point and colour plane, for a kind of image.
    title : callable
        What the curve is, for a kind of image.
    """

    def __init__(self, context: Context, name: str, address: Addressed, title: Named) -> None:
        self.context, self.name = context, name
        self._address, self._title = address, title
        self._place: tuple[OperatingPoint, str, Kind] | None = None
        self.plot = CurvePlot(context.palette, name)
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

    def chosen(self, view: View, point: OperatingPoint) -> None:
        """Draw another operating point, colour plane or kind of image."""
        self._place = point, view.plane.rstrip("0123456789"), view.kind
        self.draw()

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what in ("evaluation", "preview", "candidate"):
            self.draw()

    def draw(self) -> None:
        """Draw the curves, where the pane is seen."""
        session = self.context.session
        if self._place is None or not self.view.visible:
            return
        point, plane, kind = self._place
        if session.problem is None:
            where = html.escape(unbroken(labelled(point, plane)))
            self.title.object = f"<span class=loading>{self.name} at {where} …</span>"
            return
        found = layers(self.context)
        measured = found["measured"][0]
        planes = [s.plane for s in measured.settings if s.point == point]
        if planes and plane not in planes:  # a mosaic has no statistics over all planes
            plane = planes[0]
        kinds: tuple[Kind, ...] = (kind, "frame")  # a single frame has no other kind
        for kind in kinds:
            address = self._address(kind, point, plane)
            drawn = curves_of(found, address)
            if "measured" in drawn:
                break
        where = html.escape(unbroken(labelled(point, plane)))
        text = f"<b>{self._title(kind)}</b> <span class=quiet>{where}, half of the field</span>"
        if "measured" not in drawn:
            text = f"<span class=quiet>no {self.name} at {where}: it is not compared</span>"
        if self.title.object != text:
            self.title.object = text
        axes = curves.axes(address, measured)
        assert axes is not None
        self.plot.show(axes, [], drawn, address, curves.marks(address, measured))
        self.drawn.visible = True


def histogram(context: Context) -> PointFigure:
    """Histogram of the pixel values on a log scale."""
    return PointFigure(
        context,
        "histogram",
        lambda _, point, plane: Address("frame_skewness", point, plane),
        lambda _: "Pixel values",
    )


def spectrum(context: Context) -> PointFigure:
    """Radial power spectrum of what the image shows."""
    return PointFigure(
        context,
        "spectrum",
        lambda kind, *place: curves.whole_spectrum(PART[kind], *place),
        lambda kind: f"Radial spectrum of {OF[kind]}",
    )
