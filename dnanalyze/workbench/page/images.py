"""The images of the sensor side by side: one place, one tooltip, hot pixels above them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from bokeh.events import Tap
from bokeh.models import (
    BasicTicker,
    ColorBar,
    ColumnDataSource,
    CustomJS,
    CustomJSHover,
    LinearColorMapper,
    Range1d,
)
from bokeh.palettes import cividis, gray

from dnanalyze.loaders.captures import Window
from dnanalyze.workbench.frames import Outliers
from dnanalyze.workbench.page.style import Palette, hover, plain_figure
from dnanalyze.workbench.pictures import Picture
from dnanalyze.workbench.places import Places

TICK = 0.05  # share of the picture that the mark of a line is long
NAMES = "measured", "simulated", "difference"
MAPS = {"grey": gray(256), "cividis": cividis(256)}
ELONGATED = 4.0  # ratio of a sensor's sides from which its pixels are not square
VALUE = """
const source = sources[format];
const flat = special_vars.image_index?.flat_index;
const image = source.data.image[0];
if (flat === undefined || image === undefined) return "–";
const found = image[flat];
return Number.isFinite(found) ? found.toPrecision(5) + " DN" : "–";
"""
REPAINT = "setTimeout(() => cb_obj.change.emit(), 50);"  # Bokeh sets a text after it has painted
SQUARE = """
const {inner_width: width, inner_height: height} = figure;
if (!(width > 0 && height > 0)) return;
const ratio = elongated ? 1 : width / height / (columns / rows);
const more_x = Math.max(0, columns * (ratio - 1)) / 2;
const more_y = Math.max(0, rows * (1 / ratio - 1)) / 2;
for (const [range, start, end] of [
  [figure.x_range, -more_x, columns + more_x], [figure.y_range, rows + more_y, -more_y],
]) {
  const whole = range.reset_start === null
    || (range.start === range.reset_start && range.end === range.reset_end);
  range.bounds = null;  // the new ends would be cut at the bounds before
  if (whole) range.setv({start, end});
  range.setv({reset_start: start, reset_end: end});
  range.bounds = [Math.min(start, end), Math.max(start, end)];
}
"""  # the whole sensor with square pixels, until the user has chosen a part of it
PLACE = "return String(Math.floor(value / scale) * scale + offset)"


@dataclass(frozen=True)
class Grid:
    """Which pixels of the sensor an image has: every ``scale``-th from an offset.

    Examples
    --------
    >>> from dnanalyze.workbench.page.images import Grid
    >>> Grid(2, 1, 0).pixel(x=10.9, y=7.2)
    (7, 10)
    """

    scale: int = 1
    row: int = 0
    column: int = 0

    def pixel(self, x: float, y: float) -> tuple[int, int]:
        """Row and column of the sensor's pixel at a place of a figure."""
        across, down = (int(np.floor(v / self.scale)) * self.scale for v in (x, y))
        return down + self.row, across + self.column


class Images:
    """Three linked figures.

    Parameters
    ----------
    palette : Palette
    shape : (int, int)
        Rows and columns of the sensor.
    tapped : callable
        Called with the row and the column of a pixel that is clicked.
    moved : callable
        Called when another part of the sensor or another size is asked for.
    """

    def __init__(
        self, palette: Palette, shape: tuple[int, int], tapped: Callable[[int, int], None],
        moved: Callable[[], None],
    ) -> None:  # fmt: skip
        self._palette, self.shape, self._told, self._asked = palette, shape, tapped, moved
        self.grid = Grid()
        rows, columns = shape
        self.range_x, self.range_y = Range1d(0, columns), Range1d(rows, 0)
        self.mapper = LinearColorMapper(MAPS["grey"], low=0, high=1, nan_color=palette.card)
        self.apart = LinearColorMapper(
            _diverging(palette.name), low=-1, high=1, nan_color=palette.card
        )
        empty: dict[str, list[Any]] = {"image": [], "x": [], "y": [], "dw": [], "dh": []}
        self.sources = {
            n: ColumnDataSource({k: [] for k in empty}, name=f"image of {n}") for n in NAMES
        }
        self.far = {
            n: ColumnDataSource({"x": [], "y": [], "value": []}, name=f"outliers of {n}")
            for n in NAMES[:2]
        }
        self.marked = ColumnDataSource(
            {k: [] for k in ("x0", "y0", "x1", "y1")}, name="marked lines"
        )
        self.dotted = ColumnDataSource({"x": [], "y": []}, name="marked pixels")
        self._places: Places | None = None
        self._values = CustomJSHover(args={"sources": self.sources}, code=VALUE)
        self._across = CustomJSHover(args={"scale": 1, "offset": 0}, code=PLACE)
        self._down = CustomJSHover(args={"scale": 1, "offset": 0}, code=PLACE)
        self._inner = {"inner_width": 0, "inner_height": 0}  # screen pixels; 0: not told yet
        self.figures = {name: self._figure(name) for name in NAMES}
        first = self.figures["measured"]
        square = CustomJS(
            args={
                "figure": first, "rows": rows, "columns": columns,
                "elongated": max(rows, columns) > ELONGATED * min(rows, columns),
            },
            code=SQUARE,
        )  # fmt: skip
        for name in ("inner_width", "inner_height"):
            first.js_on_change(name, square)
            first.on_change(name, self._resized)
        for name in ("start", "end"):
            for one in (self.range_x, self.range_y):
                one.on_change(name, lambda attr, old, new: moved())

    def _figure(self, name: str) -> Any:
        p = self._palette
        mapper = self.apart if name == "difference" else self.mapper
        made = plain_figure(
            p, sizing_mode="stretch_both", x_range=self.range_x, y_range=self.range_y,
            tools="pan,wheel_zoom,reset", active_scroll="wheel_zoom", title=name,
            css_classes=[name], name=f"figure of {name}", min_border_right=8,
        )  # fmt: skip
        made.title.text_font_size = "12px"
        made.title.text_color = p.ink
        made.title.text_font_style = "normal"
        made.title.js_on_change("text", CustomJS(code=REPAINT))
        image = made.image("image", source=self.sources[name], x="x", y="y", dw="dw", dh="dh",
                           color_mapper=mapper)  # fmt: skip
        made.grid.visible = False
        made.axis.major_label_text_font_size = "9px"
        made.axis.ticker = BasicTicker(desired_num_ticks=4)
        made.xaxis.bounds, made.yaxis.bounds = (0, self.shape[1]), (0, self.shape[0])
        bar = ColorBar(
            color_mapper=mapper, width=8, padding=2, margin=0, bar_line_color=None,
            major_label_text_font_size="9px", major_label_text_color=p.ink,
            background_fill_color=p.card, ticker=BasicTicker(desired_num_ticks=5),
        )  # fmt: skip
        made.add_layout(bar, "right")
        tool = hover(
            p, [image], ("column", "$x{custom}"), ("row", "$y{custom}"),
            *((n, f"@dw{{{n}}}") for n in NAMES),
            formatters={"$x": self._across, "$y": self._down, "@dw": self._values},
        )  # fmt: skip
        made.add_tools(tool)
        made.segment("x0", "y0", "x1", "y1", source=self.marked, line_color=p.candidate,
                     line_width=2)  # fmt: skip
        made.scatter("x", "y", source=self.dotted, size=9, marker="square", fill_color=None,
                     line_color=p.candidate, line_width=1.2)  # fmt: skip
        if name in self.far:
            dots = made.scatter(
                "x", "y", source=self.far[name], size=7, fill_color=None,
                line_color=p.candidate, line_width=1.5, name=f"hot pixels {name}",
            )  # fmt: skip
            made.add_tools(
                hover(p, [dots], ("column", "$x{custom}"), ("row", "$y{custom}"),
                      ("pixel alone", "@value{0.0} DN"),
                      formatters={"$x": self._across, "$y": self._down})
            )  # fmt: skip
        made.on_event(Tap, self._tapped)
        return made

    def _tapped(self, event: Any) -> None:
        row, column = self.grid.pixel(event.x, event.y)
        if 0 <= row < self.shape[0] and 0 <= column < self.shape[1]:
            self._told(row, column)

    def _resized(self, attr: str, old: Any, new: Any) -> None:
        self._inner[attr] = int(new or 0)
        self._asked()

    @property
    def dense(self) -> float:
        """Screen pixels along a pixel of the sensor; 0 where the browser has not told it."""
        across = self._inner["inner_width"] / abs(self.range_x.end - self.range_x.start)
        down = self._inner["inner_height"] / abs(self.range_y.end - self.range_y.start)
        return max(across, down)

    def show(self, picture: Picture, grid: Grid, only: tuple[str, ...] = NAMES) -> None:
        """Draw a picture, or some of its images."""
        self.grid = grid
        for tool, offset in ((self._across, grid.column), (self._down, grid.row)):
            wanted = {"scale": grid.scale, "offset": offset}
            if tool.args != wanted:
                tool.args = wanted
        k = picture.side * grid.scale
        rows, columns = picture.measured.shape
        place = {
            "x": [picture.window.left * grid.scale], "y": [picture.window.top * grid.scale],
            "dw": [columns * k], "dh": [rows * k],
        }  # fmt: skip
        for name in only:
            image = getattr(picture, name)
            self.sources[name].data = {"image": [np.asarray(image, np.float32)], **place}
        for name, source in self.far.items():
            found = picture.outliers.get(name)
            source.data = _dots(found, grid) if found else {"x": [], "y": [], "value": []}
        self._head(picture)
        self._mark(picture.window)

    def mark(self, places: Places | None, window: Window) -> None:
        """Mark pixels, and lines at the edges of what is shown; None: nothing."""
        self._places = places
        self._mark(window)

    def _mark(self, window: Window) -> None:
        found, scale = self._places, self.grid.scale
        lines: dict[str, Any] = {k: [] for k in ("x0", "y0", "x1", "y1")}
        dots: dict[str, Any] = {"x": [], "y": []}
        if found is not None:
            (rows, columns), tick = window.shape, TICK
            ends = (window.top, window.bottom), (window.left, window.right)
            for line in (found.columns + 0.5) * scale:
                for edge, step in zip(ends[0], (rows * tick, -rows * tick), strict=True):
                    _add(lines, line, edge * scale, line, (edge + step) * scale)
            for line in (found.rows + 0.5) * scale:
                for edge, step in zip(ends[1], (columns * tick, -columns * tick), strict=True):
                    _add(lines, edge * scale, line, (edge + step) * scale, line)
            dots = {k: (found.pixels[:, i] + 0.5) * scale for i, k in ((1, "x"), (0, "y"))}
        if lines != self.marked.data:
            self.marked.data = lines
        if any(not np.array_equal(dots[k], self.dotted.data[k]) for k in dots):
            self.dotted.data = dots

    def wait(self, names: tuple[str, ...] = NAMES) -> None:
        """Say that images are being computed."""
        for name in names:
            self.figures[name].title.text = f"{_title(name)}: computing …"

    def _head(self, picture: Picture) -> None:
        """Say what an image is of: single pixels or means of blocks."""
        of = blocks(picture)
        for name, figure in self.figures.items():
            title = _title(name)
            far = picture.outliers.get(name)
            hot = f", {far.count:,} pixels > 5 σ" if far else ""
            text = f"{title} [DN]{of}{hot}"
            if figure.title.text != text:
                figure.title.text = text


def blocks(picture: Picture) -> str:
    """What a value of a picture is the mean of, to follow a title."""
    return f", means of {picture.side} × {picture.side} pixels" if picture.side > 1 else ""


def _title(name: str) -> str:
    return "measured − simulated" if name == "difference" else name


def _add(lines: dict[str, Any], x0: float, y0: float, x1: float, y1: float) -> None:
    for key, value in zip(("x0", "y0", "x1", "y1"), (x0, y0, x1, y1), strict=True):
        lines[key].append(float(value))


def _dots(found: Outliers, grid: Grid) -> dict[str, Any]:
    return {
        "x": (found.columns + 0.5) * grid.scale,
        "y": (found.rows + 0.5) * grid.scale,
        "value": found.values.astype(np.float32),
    }


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
