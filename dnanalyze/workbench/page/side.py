"""What stands beside the images: histogram, spectra, or the values of a pixel."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import panel as pn

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.page.all_spectra import AllSpectra
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.pixel import Pixel
from dnanalyze.workbench.page.point_figure import histogram, spectrum
from dnanalyze.workbench.page.style import inner

HISTOGRAM, PIXEL = "histogram", "pixel"
LATER_S = 1.0  # after the first error, or a click that comes before
KINDS: dict[str, Callable[[Context], Any]] = {
    HISTOGRAM: histogram,
    "spectrum": spectrum,
    "all spectra": AllSpectra,
    PIXEL: Pixel,
}


class Side:
    """The pane; one figure is seen, and only that is drawn.

    The histogram is there at once. The others follow when the first error is shown, since they take
    as long to make as all images, and are hidden at first: a browser that lays the page out while
    it makes a plot fails at those that are seen.

    Parameters
    ----------
    context : Context
    """

    def __init__(self, context: Context) -> None:
        self.context = context
        self._made: dict[str, Any] = {HISTOGRAM: histogram(context)}
        self._image: tuple[View, OperatingPoint] | None = None
        self.which = pn.widgets.RadioButtonGroup(
            options=list(KINDS), value=HISTOGRAM, width=290, margin=0,
            stylesheets=[inner(context.palette)],
        )  # fmt: skip
        self.which.param.watch(lambda _: context.back(self._sided), "value")
        self.view = pn.Column(
            pn.Row(self.which, margin=0), self._made[HISTOGRAM].view, margin=0,
            sizing_mode="stretch_both", css_classes=["side"],
        )  # fmt: skip
        context.listeners.append(self.update)

    def update(self, what: str) -> None:
        """Make the other figures."""
        if what == "evaluation" and len(self._made) < len(KINDS):
            self.context.document.add_timeout_callback(self._make, int(1000 * LATER_S))

    def _make(self) -> None:
        fresh = [name for name in KINDS if name not in self._made]
        with self.context.combined(exchanging=True):
            for name in fresh:
                self._made[name] = made = KINDS[name](self.context)
                if self._image is not None:
                    made.chosen(*self._image)
                made.view.visible = False
            if fresh:
                self.view.extend([self._made[name].view for name in fresh])

    def _sided(self) -> None:
        if len(self._made) < len(KINDS):
            self._make()
            self.context.document.add_timeout_callback(self._sided, int(1000 * LATER_S))
            return
        with self.context.combined():
            for name, pane in self._made.items():
                pane.view.visible = name == self.which.value
            self._made[self.which.value].draw()

    def chosen(self, view: View, point: OperatingPoint) -> None:
        """Draw what belongs to another image."""
        self._image = view, point
        for pane in self._made.values():
            pane.chosen(view, point)

    def show_pixel(self, row: int, column: int, setting: int) -> None:
        """The values of a pixel."""
        self._make()
        self._made[PIXEL].show(row, column, setting)
        self.which.value = PIXEL
