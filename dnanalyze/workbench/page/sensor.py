"""The sensor: operating points, frames measured and simulated, and the values of a pixel."""

from __future__ import annotations

import math
import time
from collections import OrderedDict
from typing import Any

import numpy as np
import pandas as pd
import panel as pn
from bokeh.events import Tap
from bokeh.models import (
    BasicTicker,
    ColorBar,
    ColumnDataSource,
    FixedTicker,
    LinearColorMapper,
    Range1d,
    TapTool,
)
from bokeh.palettes import cividis, gray
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from dnanalyze.loaders.captures import Window
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate
from dnanalyze.report.words import celsius, number
from dnanalyze.workbench import frames
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.page.background import Latest
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.downloads import downloads
from dnanalyze.workbench.page.pixel import Pixel
from dnanalyze.workbench.page.points import labelled
from dnanalyze.workbench.page.style import card, hover, inner, plain_figure

HELD = 6  # whole images kept: a view's measured and simulated ones
LARGE = 1 << 21  # pixels from which a moving slider redraws the frame only when it rests
LIVE_S = 1.0  # least time between frames while a slider moves: curve and error come first
MARGINS = 46, 82  # of an image's figure around the image: axes, title and colour bar
WIDTH, HEIGHT = 150, 166  # of an image side by side at most, screen pixels
LEAST = 100  # width and height of an image: its title and its ticks need them
ALONE = 350  # width and height of an image alone at most
SAMPLES = 192, 384  # rows and columns that are sent of an image at most: side by side, alone
MAPS = {"grey": gray(256), "cividis": cividis(256)}


class Sensor:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        p = context.palette
        self.captures = context.session.pictured
        self.shape = self.captures.sensor.shape
        self._held: OrderedDict[Any, np.ndarray] = OrderedDict()
        self._latest = Latest(context.back)
        self._asked_s = -math.inf
        self._timer: Any = None
        style = [inner(p)]
        settings = self.captures.settings
        most = max(len(s.frames) for s in settings)
        self.view_of = View()
        self.kind = pn.widgets.Select(
            options=list(frames.KINDS), value="frame", width=112, stylesheets=style, margin=0
        )
        self.frame = pn.widgets.IntInput(
            value=0, start=0, end=most - 1, width=52, stylesheets=style, margin=0
        )
        self.plane = pn.widgets.Select(
            options={n or "all pixels": n for n in frames.planes(self.captures.sensor.cfa)},
            width=88, stylesheets=style, margin=0, visible=self.captures.sensor.cfa is not None,
        )  # fmt: skip
        self.colours = pn.widgets.Select(
            options=list(MAPS), value="grey", width=78, stylesheets=style, margin=0
        )
        self.mode = pn.widgets.RadioButtonGroup(
            options=["side by side", "swipe", "blink"], value="side by side", stylesheets=style,
            margin=0, width=185,
        )  # fmt: skip
        self.contrast = pn.widgets.RangeSlider(
            name="contrast %", start=0, end=100, step=0.5, value=frames.CONTRAST,
            width=130, stylesheets=style, margin=(0, 6, 0, 6),
        )  # fmt: skip
        self.swipe = pn.widgets.FloatSlider(
            name="measured | simulated", start=0, end=1, step=0.01, value=0.5,
            show_value=False, stylesheets=style, margin=(0, 6, 4, 6), visible=False,
            sizing_mode="stretch_width",
        )  # fmt: skip
        for widget in (self.kind, self.frame, self.plane, self.colours, self.contrast, self.mode):
            widget.param.watch(lambda _: self._changed(), "value")
        self.swipe.param.watch(lambda _: self._swiped(), "value")
        self.range_x = Range1d(0, self.shape[1], bounds=(0, self.shape[1]))
        self.range_y = Range1d(self.shape[0], 0, bounds=(0, self.shape[0]))
        self.mapper = LinearColorMapper(MAPS["grey"], low=0, high=1, nan_color=p.card)
        self.difference = LinearColorMapper(_diverging(p.name), low=-1, high=1, nan_color=p.card)
        self._colour_bars: list[ColorBar] = []
        self._shown: dict[str, np.ndarray] = {}
        self._drawn: Any = None
        self.sources = {
            name: ColumnDataSource({"image": [], "x": [], "y": [], "dw": [], "dh": []})
            for name in ("measured", "simulated", "difference")
        }
        self.figures = {name: self._image(name) for name in self.sources}
        self.pixel = Pixel(context, WIDTH + MARGINS[0], HEIGHT + MARGINS[1])
        self._first_pixel = True
        images = [pn.pane.Bokeh(f, margin=0) for f in self.figures.values()]
        self.over_frames = pn.pane.Bokeh(self.pixel.over_frames, margin=0)
        self.upper = pn.Row(*images[:2], margin=0)
        self.lower = pn.Row(images[2], self.over_frames, margin=0)
        self.points = self._points()
        self.view = pn.Column(
            pn.Row(
                pn.pane.HTML("<h2>Sensor</h2>", stylesheets=style, margin=0),
                pn.layout.HSpacer(),
                *downloads("frames", self._table, self._picture, style, "the images"),
                margin=0, sizing_mode="stretch_width",
            ),
            pn.pane.Bokeh(self.points, margin=0),
            pn.Row(self.kind, self.frame, self.plane, self.colours, margin=(2, 0, 2, 0)),
            pn.Row(self.mode, self.contrast, margin=(0, 0, 4, 0)),
            self.swipe,
            self.upper,
            self.lower,
            self.pixel.title_bar,
            pn.pane.Bokeh(
                self.pixel.over_points, margin=0, sizing_mode="stretch_both", min_height=110
            ),
            styles=card(p), sizing_mode="stretch_both", margin=0,
        )  # fmt: skip
        for name in ("start", "end"):
            self.range_x.on_change(name, self._moved)
            self.range_y.on_change(name, self._moved)
        context.listeners.append(self.update)
        self._changed()

    def _image(self, name: str) -> Any:
        p = self.context.palette
        mapper = self.difference if name == "difference" else self.mapper
        made = plain_figure(
            p, width=WIDTH + MARGINS[0], height=HEIGHT + MARGINS[1], x_range=self.range_x,
            y_range=self.range_y, tools="pan,wheel_zoom,reset", active_scroll="wheel_zoom",
            title=f"{name} [DN]", css_classes=[name], x_axis_label="column", y_axis_label="row",
        )  # fmt: skip
        made.title.text_font_size = "11px"
        made.title.text_color = p.ink
        made.title.text_font_style = "normal"
        image = made.image("image", source=self.sources[name], x="x", y="y", dw="dw", dh="dh",
                           color_mapper=mapper)  # fmt: skip
        made.grid.visible = False
        made.axis.major_label_text_font_size = made.axis.axis_label_text_font_size = "9px"
        made.axis.axis_label_standoff = 0
        made.axis.ticker = BasicTicker(desired_num_ticks=3)
        bar = ColorBar(
            color_mapper=mapper, height=7, width=132, padding=1, margin=0,
            major_label_text_font_size="9px", major_label_text_color=p.ink,
            background_fill_color=p.card, ticker=BasicTicker(desired_num_ticks=3),
            orientation="horizontal", bar_line_color=None,
        )  # fmt: skip
        made.add_layout(bar, "below")
        self._colour_bars.append(bar)
        made.add_tools(hover(p, [image], ("column, row", "$x{0}, $y{0}"), (name, "@image{0.0} DN")))
        made.on_event(Tap, self._tapped)
        return made

    def _points(self) -> Any:
        """Operating points: temperature across, everything else down."""
        p, settings = self.context.palette, self.captures.settings
        rest = list(dict.fromkeys(_rest(s.point) for s in settings))
        temperatures = list(dict.fromkeys(s.point.temperature_c for s in settings))
        source = ColumnDataSource(
            {
                "x": [temperatures.index(s.point.temperature_c) for s in settings],
                "y": [len(rest) - 1 - rest.index(_rest(s.point)) for s in settings],
                "n": [f"{len(s.frames)}" for s in settings],
                "where": [labelled(s.point) for s in settings],
            }
        )
        rows = min(len(rest), 8)
        made = plain_figure(
            p, width=392, height=38 + 20 * rows, tools="tap",
            x_range=Range1d(-0.5, len(temperatures) - 0.5), y_range=Range1d(-0.5, len(rest) - 0.5),
        )  # fmt: skip
        cells = made.rect("x", "y", width=0.96, height=0.9, source=source, fill_color=p.present,
                          line_color=p.card, nonselection_alpha=0.35, fill_alpha=0.85)  # fmt: skip
        made.text("x", "y", "n", source=source, text_align="center", text_baseline="middle",
                  text_font_size="10px", text_color=p.card, nonselection_text_color=p.ink,
                  nonselection_text_alpha=1.0)  # fmt: skip
        made.grid.visible = False
        made.xaxis.ticker = FixedTicker(ticks=list(range(len(temperatures))))
        made.xaxis.major_label_overrides = {
            i: "unknown T" if t is None else celsius(t) for i, t in enumerate(temperatures)
        }
        made.yaxis.ticker = FixedTicker(ticks=list(range(len(rest))))
        made.yaxis.major_label_overrides = {len(rest) - 1 - i: r for i, r in enumerate(rest)}
        made.add_tools(hover(p, [cells], ("operating point", "@where"), ("frames", "@n")))
        made.select_one(TapTool).renderers = [cells]
        source.selected.indices = [0]
        source.selected.on_change("indices", self._chosen)
        return made

    def _chosen(self, attr: str, old: Any, new: list[int]) -> None:
        if new:
            self.view_of = View(new[0])
            self.pixel.chosen(new[0])
            self._changed()

    def update(self, what: str) -> None:
        """Draw what has changed."""
        live = self.kind.value == "frame" and math.prod(self.shape) <= LARGE
        due = time.monotonic() - self._asked_s > LIVE_S
        if what == "evaluation" or (what == "preview" and live and due):
            self._changed()

    def _moved(self, attr: str, old: float, new: float) -> None:
        self._changed()

    def _changed(self) -> None:
        """Ask for the images of the present view, window and model."""
        count = len(self.captures.settings[self.view_of.setting].frames)
        view = View(
            self.view_of.setting, self.kind.value, min(self.frame.value or 0, count - 1),
            self.plane.value or "",
        )  # fmt: skip
        self.swipe.visible = self.mode.value == "swipe"
        self.figures["simulated"].visible = self.mode.value == "side by side"
        self.figures["difference"].visible = self.mode.value == "side by side"
        alone = self.mode.value != "side by side"
        self.over_frames.visible = not alone
        if self.mode.value == "swipe":
            self.figures["measured"].title.text = "measured | simulated [DN]"
        width, height = self._size(alone)
        for bar in self._colour_bars:
            bar.width = min(132, width - 14)
        for figure in self.figures.values():
            figure.width, figure.height = width + MARGINS[0], height + MARGINS[1]
        shown = self.context.shown
        model = shown.model if shown is not None else None
        preview = shown is not None and shown.preview
        scale = 1 if not view.plane else len(self.captures.sensor.cfa or ((),))
        window = self._window(scale)
        self._blink()
        self._asked_s = time.monotonic()
        self._latest.ask(
            lambda: self._images(view, window, model, preview),
            lambda x: self._show(x, view, window, scale),
            lambda error: self.context.session.tell(str(error)),
        )  # fmt: skip

    def _size(self, alone: bool) -> tuple[int, int]:
        """Width and height of an image on the screen, in the sensor's proportions or near."""
        rows, columns = self.shape
        wide, high = (ALONE, ALONE) if alone else (WIDTH, HEIGHT)
        scale = min(wide / columns, high / rows)
        return max(LEAST, round(columns * scale)), max(LEAST, round(rows * scale))

    def _window(self, scale: int) -> Window:
        rows, columns = (n // scale for n in self.shape)
        left, right = sorted((self.range_x.start / scale, self.range_x.end / scale))
        top, bottom = sorted((self.range_y.start / scale, self.range_y.end / scale))
        left, top = max(0, int(left)), max(0, int(top))
        right, bottom = min(columns, int(np.ceil(right))), min(rows, int(np.ceil(bottom)))
        return Window(top, max(top + 1, bottom), left, max(left + 1, right))

    def _images(self, view: View, window: Window, model: NoiseModel | None, preview: bool) -> Any:
        """Measured, simulated and difference images, and the ends of their contrasts.

        A preview keeps the measured image and the contrasts that are shown.
        """
        measured = self._whole(view, None)
        simulated = np.full_like(measured, np.nan) if model is None else self._whole(view, model)
        apart = measured - simulated
        most = SAMPLES[self.mode.value != "side by side"]
        if preview and self._drawn == (view, window, self.mode.value):
            made = [frames.for_screen(x, window, most) for x in (simulated, apart)]
            return (self._shown["measured"], *made), None
        images = tuple(frames.for_screen(x, window, most) for x in (measured, simulated, apart))
        cut, (low, high) = window.slices, self.contrast.value
        ends = frames.contrast([measured[cut], simulated[cut]], low, high)
        spread = max(abs(e) for e in frames.contrast([images[2]], low, high))
        return images, (ends, spread)

    def _whole(self, view: View, model: NoiseModel | None) -> np.ndarray:
        """A whole image, of the captures or of a model's; the last few are kept."""
        key = view, model
        if key not in self._held:
            captures = self.captures
            if model is not None:
                layout = [(s.point, len(s.frames)) for s in captures.settings]
                captures = simulate(
                    model.in_codes, self.shape, layout, "simulation", captures.sensor
                )
            self._held[key] = frames.image(captures, view)
            while len(self._held) > HELD:
                self._held.popitem(last=False)
        return self._held[key]

    def _show(self, found: Any, view: View, window: Window, scale: int) -> None:
        """Draw the images; those of a preview at the contrast that there is."""
        (measured, simulated, difference), ends = found
        if ends is not None:
            (low, high), spread = ends
            self.mapper.palette = MAPS[self.colours.value]
            self.mapper.low, self.mapper.high = low, high
            self.difference.low, self.difference.high = -spread, spread
        self._shown = {"measured": measured, "simulated": simulated, "difference": difference}
        place = {
            "x": [window.left * scale], "y": [window.top * scale],
            "dw": [(window.right - window.left) * scale],
            "dh": [(window.bottom - window.top) * scale],
        }  # fmt: skip
        same = self._drawn == (view, window, self.mode.value)
        for name, source in self.sources.items():
            # drawing an image takes a browser as long as the curve: the difference follows at rest
            if not same or name == "simulated" or (name == "difference" and ends is not None):
                source.data = {"image": [self._shown[name]], **place}
        self._drawn = view, window, self.mode.value
        if self.mode.value == "swipe":
            self._swiped()
        if self._first_pixel:
            self._first_pixel = False
            row, column = np.unravel_index(np.nanargmax(measured), measured.shape)
            k = (window.bottom - window.top) / measured.shape[0]
            self._pixel(window.top + int(row * k), window.left + int(column * k))

    def _swiped(self) -> None:
        """Left of the handle the measured image, right of it the simulated one."""
        if not self._shown or self.mode.value != "swipe":
            return
        image = self._shown["measured"].copy()
        at = round(self.swipe.value * image.shape[1])
        image[:, at:] = self._shown["simulated"][:, at:]
        source = self.sources["measured"]
        source.data = {**source.data, "image": [image]}

    def _blink(self) -> None:
        """Measured and simulated in turn, each for .6 s."""
        if self.mode.value == "blink" and self._timer is None:
            state = {"which": "measured"}

            def turn() -> None:
                state["which"] = "simulated" if state["which"] == "measured" else "measured"
                if state["which"] in self._shown:
                    source = self.sources["measured"]
                    source.data = {**source.data, "image": [self._shown[state["which"]]]}
                    self.figures["measured"].title.text = f"{state['which']} [DN]"

            self._timer = pn.state.add_periodic_callback(turn, period=600)
        elif self.mode.value != "blink" and self._timer is not None:
            self._timer.stop()
            self._timer = None
        if self.mode.value == "side by side":
            self.figures["measured"].title.text = "measured [DN]"

    def _table(self) -> pd.DataFrame:
        """One row a pixel of the images as they are shown."""
        if not self._shown or self._drawn is None:
            return pd.DataFrame()
        window = self._drawn[1]
        rows, columns = self._shown["measured"].shape
        y = np.linspace(window.top, window.bottom, rows, endpoint=False)
        x = np.linspace(window.left, window.right, columns, endpoint=False)
        row, column = (z.astype(int).ravel() for z in np.meshgrid(y, x, indexing="ij"))
        return pd.DataFrame(
            {"row": row, "column": column} | {n: z.ravel() for n, z in self._shown.items()}
        )

    def _picture(self) -> Figure:
        """The images side by side, with the contrasts of the page."""
        made = Figure(figsize=(12, 4), layout="constrained")
        if not self._shown or self._drawn is None:
            return made
        window = self._drawn[1]
        extent = (window.left, window.right, window.bottom, window.top)
        for ax, (name, image) in zip(made.subplots(1, 3), self._shown.items(), strict=True):
            mapper = self.difference if name == "difference" else self.mapper
            drawn = ax.imshow(
                image, cmap=ListedColormap(mapper.palette), vmin=mapper.low, vmax=mapper.high,
                extent=extent, interpolation="nearest",
            )  # fmt: skip
            ax.set(title=name, xlabel="column", ylabel="row")
            made.colorbar(drawn, ax=ax, label="pixel value [DN]")
        return made

    def _tapped(self, event: Any) -> None:
        self._pixel(int(event.y), int(event.x))

    def _pixel(self, row: int, column: int) -> None:
        if 0 <= row < self.shape[0] and 0 <= column < self.shape[1]:
            self.pixel.show(row, column, self.view_of.setting)


def _rest(point: Any) -> str:
    """Everything of an operating point but its temperature."""
    parts = [point.channel or ""]
    parts += [f"{number(point.exposure_s)} s"] if point.exposure_s is not None else []
    parts += [f"gain {number(point.gain)}"] if point.gain is not None else []
    return ", ".join(x for x in parts if x) or "frames"


def _diverging(theme: str) -> list[str]:
    """Blue, neutral, orange."""
    middle = (0.16, 0.18, 0.2) if theme == "dark" else (0.96, 0.96, 0.96)
    ends = ((0.13, 0.4, 0.75), (0.85, 0.42, 0.1))
    out = []
    for t in np.linspace(-1, 1, 255):
        end = ends[0] if t < 0 else ends[1]
        rgb = [round(255 * (m + (e - m) * abs(t))) for m, e in zip(middle, end, strict=True)]
        out.append("#{:02x}{:02x}{:02x}".format(*rgb))
    return out
