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


def _histogram(_: Kind, point: OperatingPoint, plane: str) -> Address:
    return Address("frame_skewness", point, plane)


def _spectrum(kind: Kind, point: OperatingPoint, plane: str) -> Address:
    return curves.whole_spectrum(PART[kind], point, plane)


CURVES: dict[str, Callable[[Kind, OperatingPoint, str], Address]] = {
    "histogram": _histogram, "spectrum": _spectrum
}  # fmt: skip


class PointFigure:
    """The pane: one plot, of the histogram or of the radial spectrum.

    Parameters
    ----------
    context : Context
    """

    def __init__(self, context: Context) -> None:
        self.context = context
        self._which = next(iter(CURVES))
        self._place: tuple[OperatingPoint, str, Kind] | None = None
        self.plot = CurvePlot(context.palette, "beside")
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

    def show(self, which: str) -> None:
        """Draw the histogram or the spectrum."""
        self._which = which
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
            self.title.object = f"<span class=loading>{self._which} at {where} …</span>"
            return
        found = layers(self.context)
        measured = found["measured"][0]
        planes = [s.plane for s in measured.settings if s.point == point]
        if planes and plane not in planes:  # a mosaic has no statistics over all planes
            plane = planes[0]
        kinds: tuple[Kind, ...] = (kind, "frame")  # a single frame has no other kind
        for kind in kinds:
            address = CURVES[self._which](kind, point, plane)
            drawn = curves_of(found, address)
            if "measured" in drawn:
                break
        where = html.escape(unbroken(labelled(point, plane)))
        title = f"Radial spectrum of {OF[kind]}" if self._which == "spectrum" else "Pixel values"
        text = f"<b>{title}</b> <span class=quiet>{where}, half of the field</span>"
        if "measured" not in drawn:
            text = f"<span class=quiet>no {self._which} at {where}: it is not compared</span>"
        if self.title.object != text:
            self.title.object = text
        axes = curves.axes(address, measured)
        assert axes is not None
        self.plot.show(axes, [], drawn, address, curves.marks(address, measured))
        self.drawn.visible = True
