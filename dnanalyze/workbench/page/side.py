"""What stands beside the images: histogram, spectra, or the values of a pixel."""

from __future__ import annotations

from typing import Any

import panel as pn

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.page.all_spectra import AllSpectra
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.pixel import Pixel
from dnanalyze.workbench.page.point_figure import histogram, spectrum
from dnanalyze.workbench.page.style import inner

PIXEL = "pixel"


class Side:
    """The pane; one figure of it is seen, and only that is drawn.

    Parameters
    ----------
    context : Context
    """

    def __init__(self, context: Context) -> None:
        self.context = context
        self.histogram, self.spectrum = histogram(context), spectrum(context)
        self.all_spectra, self.pixel = AllSpectra(context), Pixel(context)
        self._seen: dict[str, Any] = {
            "histogram": self.histogram, "spectrum": self.spectrum,
            "all spectra": self.all_spectra, PIXEL: self.pixel,
        }  # fmt: skip
        self.which = pn.widgets.RadioButtonGroup(
            options=list(self._seen), value="histogram", width=290, margin=0,
            stylesheets=[inner(context.palette)],
        )  # fmt: skip
        self.which.param.watch(lambda _: context.back(self._sided), "value")
        self.view = pn.Column(
            pn.Row(self.which, margin=0), *(pane.view for pane in self._seen.values()), margin=0,
            sizing_mode="stretch_both", css_classes=["side"],
        )  # fmt: skip
        self._sided()

    def _sided(self) -> None:
        for name, pane in self._seen.items():
            pane.view.visible = name == self.which.value
        if self.which.value != PIXEL:
            self._seen[self.which.value].draw()

    def chosen(self, view: View, point: OperatingPoint) -> None:
        """Draw what belongs to another image."""
        self.pixel.chosen(view.setting)
        self.histogram.chosen(point, view.plane, view.kind)
        self.spectrum.chosen(point, view.plane, view.kind)
        self.all_spectra.chosen(view.kind)

    def show_pixel(self, row: int, column: int, setting: int) -> None:
        """The values of a pixel."""
        self.which.value = PIXEL
        self.pixel.show(row, column, setting)
