"""The sensor: frames measured, simulated and their difference, and what stands beside them."""

from __future__ import annotations

import html
import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import panel as pn
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from dnanalyze.loaders.captures import Window
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.report.words import plural
from dnanalyze.workbench import frames
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.measuring import LOOK_S, Superseded
from dnanalyze.workbench.page.background import Latest
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.downloads import downloads
from dnanalyze.workbench.page.enlarge import enlarger
from dnanalyze.workbench.page.images import MAPS, NAMES, Grid, Images, blocks
from dnanalyze.workbench.page.points import labelled, without_shared
from dnanalyze.workbench.page.side import Side
from dnanalyze.workbench.page.style import card, inner
from dnanalyze.workbench.pictures import Picture
from dnanalyze.workbench.places import Places
from dnanalyze.workbench.worst import worst_view

REDRAWN_AT_REST = 1 << 21  # pixels from which a moving slider redraws the frame only when it rests
LIVE_S = 1.0  # least time between frames while a slider moves: curve and error come first
FEWEST = 420  # rows or columns that are sent of an image of unknown size on the screen
LARGE_HEIGHT = 900  # the same at most
MODES = "side by side", "swipe", "blink"


class Sensor:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        p = context.palette
        self.pictures = context.session.pictures
        self.captures = self.pictures.captures
        self._latest, self._brushing = Latest(context.back), Latest(context.back)
        self._request = 0
        self._asked_s = -math.inf
        self._timer: Any = None
        self._turned = False
        self._own = False  # whether the user has chosen a view
        self._quiet = False
        self._drawn: Any = None
        self._shown: Picture | None = None
        self._ends: tuple[float, float] = (0.0, 1.0)
        style = self._style = [inner(p)]
        self._make_controls(style)
        self.marks = pn.pane.HTML("", stylesheets=style, margin=(4, 0, 0, 4), css_classes=["marks"])
        self.images = Images(p, self.captures.sensor.shape, self._pixel, self._changed)
        self.side = Side(context, self.view_of, self.captures.settings[0].point)
        self.places = pn.Column(
            *(
                pn.pane.Bokeh(f, margin=0, sizing_mode="stretch_both", css_classes=[n])
                for n, f in self.images.figures.items()
            ),
            self.side.view, sizing_mode="stretch_both", margin=0, stylesheets=[GRID],
            css_classes=["images"],
        )  # fmt: skip
        self.view = pn.Column(
            styles=card(p) | {"overflow": "hidden", "container-type": "size"},
            sizing_mode="stretch_both", margin=0,
        )  # fmt: skip
        self.view.extend([
            pn.Row(
                pn.pane.HTML("<h2>Frames</h2>", stylesheets=style, margin=(3, 6, 0, 0)),
                self.point, self.kind, self.frame, self.plane, self.mode, self.swipe,
                self.colours, self.low, self.high, self.auto, self.hot,
                self.marks,
                pn.Row(
                    *downloads("frames", self._table, self._picture, style, "the images"),
                    enlarger(self.view, style), margin=0, styles={"margin-left": "auto"},
                ),
                margin=(0, 0, 4, 0), sizing_mode="stretch_width",
                styles={"flex-wrap": "wrap", "row-gap": "3px", "min-width": "0"},
            ),
            self.places,
        ])  # fmt: skip
        context.listeners.append(self.update)
        self._choose_view(self.view_of)
        self._lead()  # a second page begins where the first one does
        self._changed()

    def _make_controls(self, style: list[str]) -> None:
        settings = self.captures.settings
        labels = without_shared([labelled(s.point) for s in settings])
        small = {"stylesheets": style, "margin": (0, 4, 0, 0)}
        self.view_of = View()
        self.point = pn.widgets.Select(
            options={
                f"{label}  ({plural(len(s.frames), 'frame')})": i
                for i, (label, s) in enumerate(zip(labels, settings, strict=True))
            },
            value=0, width=190, css_classes=["point"], **small,
        )  # fmt: skip
        self.kind = pn.widgets.Select(
            options=list(frames.KINDS), value="frame", width=118, css_classes=["kind"], **small
        )
        self.frame = pn.widgets.IntInput(
            value=0, start=0, end=max(len(s.frames) for s in settings) - 1, width=54, **small
        )
        cfa = self.captures.sensor.cfa
        self.plane = pn.widgets.Select(
            options={n or "all pixels": n for n in frames.planes(cfa)}, width=88,
            visible=cfa is not None, **small,
        )  # fmt: skip
        self.colours = pn.widgets.Select(options=list(MAPS), value="grey", width=80, **small)
        self.mode = pn.widgets.RadioButtonGroup(
            options=list(MODES), value=MODES[0], width=190, **small
        )
        self.swipe = pn.widgets.FloatSlider(
            name="", start=0, end=1, step=0.01, value=0.5, show_value=False, tooltips=False,
            visible=False, width=110, **small,
        )  # fmt: skip
        number = {"width": 62, **small}
        self.low = pn.widgets.TextInput(placeholder="min", css_classes=["low"], **number)
        self.high = pn.widgets.TextInput(placeholder="max", css_classes=["high"], **number)
        self.auto = pn.widgets.Toggle(name="auto scale", value=True, **small)
        self.hot = pn.widgets.Toggle(name="pixels > 5 σ", value=False, **small)
        self._watch(self._chosen, self.point, self.kind, self.frame, self.plane)
        self._watch(self._changed, self.colours, self.mode, self.hot, self.auto)
        self._watch(self._typed, self.low, self.high)
        self._watch(self._compose, self.swipe)

    def _watch(self, call: Callable[[], None], *widgets: Any) -> None:
        """Call a function after the user has changed a widget, with the document's lock."""

        def changed(_: Any) -> None:
            if not self._quiet:
                self.context.back(call)

        for widget in widgets:
            widget.param.watch(changed, "value")

    # What is shown

    def update(self, what: str) -> None:
        """Draw what has changed."""
        live = self.kind.value == "frame" and math.prod(self.images.shape) <= REDRAWN_AT_REST
        due = time.monotonic() - self._asked_s > LIVE_S
        if what in ("evaluation", "diagnosis", "yardstick"):
            before = self.view_of
            self._lead()
            if what != "yardstick" or self.view_of != before:
                self._changed()
        elif what == "preview" and live and due:
            self._changed()
        elif what == "brush":
            self._brush()

    def _brush(self) -> None:
        """Mark where the chosen statistic comes from, in the image that shows it."""
        address = self.context.brushed
        points = [s.point for s in self.captures.settings]
        if address is None or address.point not in points:
            self.images.mark(None, self._shown_window())
            return
        setting = points.index(address.point)
        cfa = self.captures.sensor.cfa
        sites = [n for n in frames.planes(cfa) if n and n.rstrip("0123456789") == address.plane]
        plane = sites[0] if sites else ""

        def show(found: Places | None) -> None:
            if self.context.brushed is not address:
                return
            self.marks.object = (
                "" if found is None
                else f"<span class=quiet>□ marked: {html.escape(found.text)}</span>"
            )  # fmt: skip
            if found is not None:
                self._own = True
                self._choose_view(View(setting, found.kind, 0, plane))
            self.images.mark(found, self._shown_window())
            self._changed()

        self._brushing.ask(
            lambda: self.pictures.places(address.name, setting, plane),
            show,
            lambda error: self.context.session.tell(str(error)),
        )

    def _shown_window(self) -> Window:
        if self._shown is None:
            return Window.whole(self.images.shape)
        return self._shown.window

    def _lead(self) -> None:
        """Show where the model fails most, until the user has chosen a view.

        Once an effect is named, its own statistics tell where.
        """
        session = self.context.session
        evaluation, history = session.evaluation, session.history
        if self._own or evaluation is None or history is None:
            return
        found = session.diagnosis
        names: tuple[str, ...] = ()
        if found is not None and found["node"] == history.at and found["verdict"] == "missing":
            effect = next(
                (c["effect"] for c in found["candidates"] if c["effect"] not in found["ordinary"]),
                None,
            )
            names = session.known[effect].fingerprint if effect in session.known else ()
        if names or history.at <= 1:
            self._choose_view(worst_view(evaluation.rows, self.captures, names) or self.view_of)

    def _choose_view(self, view: View) -> None:
        self.view_of, self._quiet = view, True
        try:
            self.point.value, self.kind.value = view.setting, view.kind
            self.frame.value, self.plane.value = view.frame, view.plane
        finally:
            self._quiet = False
        self._adjusted()

    def _chosen(self) -> None:
        self._own = True
        count = len(self.captures.settings[self.point.value].frames)
        number = min(self.frame.value or 0, count - 1)
        self.view_of = View(self.point.value, self.kind.value, number, self.plane.value or "")
        self._adjusted()
        self._changed()

    def _adjusted(self) -> None:
        self.frame.visible = self.view_of.kind == "frame"
        self.side.chosen(self.view_of, self.captures.settings[self.view_of.setting].point)

    def _pixel(self, row: int, column: int) -> None:
        self.side.show_pixel(row, column, self.view_of.setting)

    # Images

    def _changed(self) -> None:
        """Ask for the images of the present view, window and model."""
        alone = self.mode.value != MODES[0]
        self.swipe.visible = self.mode.value == "swipe"
        classes = ["images", "alone"] if alone else ["images"]
        if self.places.css_classes != classes:
            self.places.css_classes = classes
        self._blink()
        shown, view = self.context.shown, self.view_of
        model = shown.model if shown is not None else None
        preview = shown is not None and shown.preview
        grid = self._grid(view.plane)
        window = self._window(grid.scale)
        cells = max(window.shape) * grid.scale * self.images.dense  # a pixel fewer would be skipped
        most = min(LARGE_HEIGHT, round(cells) or FEWEST)
        far = self.hot.value
        self._asked_s = time.monotonic()
        fresh = self._drawn is None or self._drawn[0] != view
        if fresh:
            self.images.wait()

        def look() -> None:
            """Give way to a newer request, and to a slider that moves; its own frame does not."""
            while not self._latest.waiting:
                if preview or not self.context.session.moving:
                    return
                time.sleep(LOOK_S)
            raise Superseded

        def ask(model: NoiseModel | None) -> None:
            self._latest.ask(
                lambda: self.pictures.picture(view, window, model, most, far, look),
                lambda x: show(x, model),
                lambda error: self.context.session.tell(str(error)),
            )

        self._request = request = self._request + 1

        def show(picture: Picture, of: NoiseModel | None) -> None:
            self._show(picture, grid, preview and not fresh)
            if of is None:
                self.images.wait(NAMES[1:])
                if model is not None and request == self._request:
                    ask(model)

        ask(None if fresh else model)  # the frame itself first: a simulation takes longer

    def _grid(self, plane: str) -> Grid:
        cfa = self.captures.sensor.cfa
        if not plane or cfa is None:
            return Grid()
        return Grid(len(cfa), int(plane[-2]), int(plane[-1]))

    def _window(self, scale: int) -> Window:
        rows, columns = (n // scale for n in self.images.shape)
        x, y = self.images.range_x, self.images.range_y
        left, right = sorted((x.start / scale, x.end / scale))
        top, bottom = sorted((y.start / scale, y.end / scale))
        left, top = (min(max(0, int(v)), n - 1) for v, n in ((left, columns), (top, rows)))
        right, bottom = min(columns, math.ceil(right)), min(rows, math.ceil(bottom))
        return Window(top, max(top + 1, bottom), left, max(left + 1, right))

    def _show(self, picture: Picture, grid: Grid, preview: bool) -> None:
        """Draw the images; those of a preview at the contrast that there is."""
        same = self._drawn == (picture.view, picture.window, picture.side)
        self._drawn, self._shown = (picture.view, picture.window, picture.side), picture
        with self.context.combined():
            if not (preview and same):
                self._scale(picture)
            # drawing an image takes a browser as long as the curve: the difference follows at rest
            self.images.show(picture, grid, ("simulated",) if preview and same else NAMES)
            self._compose()

    def _scale(self, picture: Picture) -> None:
        mapper, apart = self.images.mapper, self.images.apart
        mapper.palette = MAPS[self.colours.value]
        if self.auto.value:
            self._ends = frames.contrast([picture.measured])
            self._quiet = True
            try:
                self.low.value, self.high.value = (f"{x:.5g}" for x in self._ends)
            finally:
                self._quiet = False
        mapper.low, mapper.high = self._ends
        spread = max(abs(e) for e in frames.contrast([picture.difference]))
        apart.low, apart.high = -spread, spread

    def _typed(self) -> None:
        """Ends of the grey scale as typed; a new image leaves alone what is being typed."""
        self._quiet = True
        self.auto.value = False
        self._quiet = False
        try:
            low, high = float(self.low.value), float(self.high.value)
            if not (math.isfinite(low) and math.isfinite(high) and low < high):
                raise ValueError
        except ValueError:
            self.context.session.tell("scale of the frames: two numbers in DN, min below max")
            return
        self.context.session.tell("")
        self._ends = low, high
        self.images.mapper.low, self.images.mapper.high = low, high

    def _compose(self) -> None:
        """Measured and simulated in one place: swiped, or in turn."""
        picture, mode = self._shown, self.mode.value
        if picture is None or mode == MODES[0]:
            return
        title = self.images.figures["measured"].title
        if mode == "swipe":
            image = picture.measured.copy()
            at = round(self.swipe.value * image.shape[1])
            image[:, at:] = picture.simulated[:, at:]
            title.text = f"measured | simulated [DN]{blocks(picture)}"
        else:
            image = picture.simulated if self._turned else picture.measured
            shown = "simulated" if self._turned else "measured"
            title.text = f"{shown} [DN]{blocks(picture)}"
        source = self.images.sources["measured"]
        source.data = {**source.data, "image": [np.asarray(image, np.float32)]}

    def _blink(self) -> None:
        """Measured and simulated in turn, each for .6 s."""
        blinking = self.mode.value == "blink"
        if blinking and self._timer is None:

            def turn() -> None:
                self._turned = not self._turned
                self._compose()

            self._timer = self.context.every(600, turn)
        elif not blinking and self._timer is not None:
            self._timer.stop()
            self._timer, self._turned = None, False

    # To take away

    def _table(self) -> pd.DataFrame:
        """One row a block of the images: its first pixel, its size, and means over its pixels."""
        picture = self._shown
        if picture is None:
            return pd.DataFrame()
        grid, window, k = self.images.grid, picture.window, picture.side
        rows, columns = picture.measured.shape
        row, column = (z.ravel() for z in np.mgrid[:rows, :columns])
        made = pd.DataFrame(
            {
                "row": (window.top + row * k) * grid.scale + grid.row,
                "column": (window.left + column * k) * grid.scale + grid.column,
                "rows": np.minimum(k, window.bottom - window.top - row * k),
                "columns": np.minimum(k, window.right - window.left - column * k),
            }
        )
        images = {f"{n}_mean_dn": getattr(picture, n).ravel() for n in NAMES}
        point = self.captures.settings[picture.view.setting].point
        kind = picture.view.kind
        said = f"frame {picture.view.frame}" if kind == "frame" else kind
        return made.assign(**images, image=said, operating_point=labelled(point))

    def _picture(self) -> Figure:
        """The images side by side, with the contrasts of the page."""
        made = Figure(figsize=(12, 4), layout="constrained")
        picture = self._shown
        if picture is None:
            return made
        window = picture.window
        extent = (window.left, window.right, window.bottom, window.top)
        for ax, name in zip(made.subplots(1, 3), NAMES, strict=True):
            mapper = self.images.apart if name == "difference" else self.images.mapper
            drawn = ax.imshow(
                getattr(picture, name), cmap=ListedColormap(mapper.palette), vmin=mapper.low,
                vmax=mapper.high, extent=extent, interpolation="nearest",
            )  # fmt: skip
            ax.set(title=name, xlabel="column", ylabel="row")
            made.colorbar(drawn, ax=ax, label="pixel value [DN]")
        point = self.captures.settings[picture.view.setting].point
        made.suptitle(f"{picture.view.kind}, {labelled(point)}", fontsize=10)
        return made


GRID = """
:host { display:grid !important; grid-template-columns:repeat(3, minmax(0, 1fr)) minmax(0, 1.15fr);
  grid-template-rows:minmax(0, 1fr); gap:6px; min-height:0;
  --side:auto; --alone:auto; --beside:3 / -1; --rows:auto; }
@container (max-width:1260px) { :host { grid-template-columns:repeat(3, minmax(0, 1fr));
  grid-template-rows:minmax(0, 1fr) minmax(0, 0.85fr);
  --side:1 / -1; --alone:1 / span 2; --beside:3; --rows:1 / -1; }
  :host(.alone) .difference { display:none !important; } }
@container (min-height:700px) and (max-aspect-ratio:2) { :host {
  grid-template-columns:repeat(2, minmax(0, 1fr)); grid-template-rows:repeat(2, minmax(0, 1fr));
  --side:auto; --alone:1; --beside:2; --rows:1 / -1; }
  :host(.alone) { grid-template-columns:minmax(0, 2fr) minmax(0, 1fr); }
  :host(.alone) .difference { display:none !important; } }
.side { grid-column:var(--side); }
:host(.alone) .measured { grid-column:var(--alone); grid-row:var(--rows); }
:host(.alone) .side { grid-column:var(--beside); grid-row:var(--rows); }
:host(.alone) .simulated { display:none !important; }
"""  # in a row; the histogram below the images where it is narrow; two by two where it is high;
# swiped or blinking, one image is as high as there is room, with the difference beside it in a row;
# one change of a class places all at once: Bokeh keeps sizes from between two changes
