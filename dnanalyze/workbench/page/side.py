"""What stands beside the images: histogram, spectra, or the values of a pixel."""

from __future__ import annotations

import panel as pn

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.page.all_spectra import AllSpectra
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.pixel import Pixel
from dnanalyze.workbench.page.point_figure import CURVES, PointFigure
from dnanalyze.workbench.page.style import inner

ALL_SPECTRA, PIXEL = "all spectra", "pixel"


class Side:
    """The pane; one figure of it is seen.

    Parameters
    ----------
    context : Context
    """

    def __init__(self, context: Context) -> None:
        self.context = context
        self.curves, self.all_spectra = PointFigure(context), AllSpectra(context)
        self.pixel = Pixel(context)
        self.which = pn.widgets.RadioButtonGroup(
            options=[*CURVES, ALL_SPECTRA, PIXEL], value=next(iter(CURVES)), width=290, margin=0,
            stylesheets=[inner(context.palette)],
        )  # fmt: skip
        self.which.param.watch(lambda _: context.back(self._sided), "value")
        self.view = pn.Column(
            pn.Row(self.which, margin=0), self.curves.view, self.all_spectra.view, self.pixel.view,
            margin=0, sizing_mode="stretch_both", css_classes=["side"],
        )  # fmt: skip
        self._see()

    def _see(self) -> None:
        which = self.which.value
        self.curves.view.visible = which in CURVES
        self.all_spectra.view.visible = which == ALL_SPECTRA
        self.pixel.view.visible = which == PIXEL

    def _sided(self) -> None:
        with self.context.combined():
            self._see()
            if self.which.value in CURVES:
                self.curves.show(self.which.value)
            self.all_spectra.draw()

    def chosen(self, view: View, point: OperatingPoint) -> None:
        """Draw what belongs to another image."""
        for pane in (self.curves, self.all_spectra, self.pixel):
            pane.chosen(view, point)

    def show_pixel(self, row: int, column: int, setting: int) -> None:
        """The values of a pixel."""
        self.which.value = PIXEL
        self.pixel.show(row, column, setting)
