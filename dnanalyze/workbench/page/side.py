"""What stands beside the images: histogram, spectra, or the values of a pixel."""

from __future__ import annotations

from typing import Any

import panel as pn

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.page.all_spectra import AllSpectra
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.pixel import Pixel
from dnanalyze.workbench.page.point_figure import CURVES, PointFigure
from dnanalyze.workbench.page.style import inner

ALL_SPECTRA, PIXEL = "all spectra", "pixel"
FIGURES = dict.fromkeys(CURVES, PointFigure) | {ALL_SPECTRA: AllSpectra, PIXEL: Pixel}


class Side:
    """The pane; one figure of it is seen, and each is made when it is first chosen.

    Parameters
    ----------
    context : Context
    view : View
    point : OperatingPoint
        Of the images.
    """

    def __init__(self, context: Context, view: View, point: OperatingPoint) -> None:
        self.context = context
        self._of = view, point
        self._made: dict[type, Any] = {}
        self.which = pn.widgets.RadioButtonGroup(
            options=[*CURVES, ALL_SPECTRA, PIXEL], value=next(iter(CURVES)), width=290, margin=0,
            stylesheets=[inner(context.palette)],
        )  # fmt: skip
        self.which.param.watch(lambda _: context.back(self.open), "value")
        self.figures = pn.Column(sizing_mode="stretch_both", margin=0, styles={"min-height": "0"})
        self.view = pn.Column(
            pn.Row(self.which, margin=0), self.figures, margin=0, sizing_mode="stretch_both",
            css_classes=["side"],
        )  # fmt: skip

    def open(self) -> None:
        """Draw the chosen figure, and send it where it is the first of its kind."""
        with self.context.combined(exchanging=True):
            kind = FIGURES[self.which.value]
            fresh = kind not in self._made
            if fresh:
                self._made[kind] = kind(self.context)
                self._made[kind].chosen(*self._of)
            shown = self._made[kind]
            for pane in self._made.values():
                pane.view.visible = pane is shown
            if isinstance(shown, PointFigure):
                shown.show(self.which.value)
            else:
                shown.draw()
            if fresh:
                self.context.send(self.figures, [pane.view for pane in self._made.values()])

    def chosen(self, view: View, point: OperatingPoint) -> None:
        """Draw what belongs to another image."""
        self._of = view, point
        for pane in self._made.values():
            pane.chosen(view, point)

    def show_pixel(self, row: int, column: int, setting: int) -> None:
        """The values of a pixel."""
        self.which.value = PIXEL
        self.open()
        self._made[Pixel].show(row, column, setting)
