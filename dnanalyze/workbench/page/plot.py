"""A plot of curves by layer; one figure, whose axes change with what is shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from bokeh.models import (
    BasicTicker,
    BasicTickFormatter,
    BoxAnnotation,
    ColumnDataSource,
    FixedTicker,
    LinearScale,
    LogScale,
    Range1d,
    Span,
    Whisker,
)

from dnanalyze.workbench.curves import Axes, Curve, Mark, residual
from dnanalyze.workbench.page.log_axis import log_formatter, log_ticker
from dnanalyze.workbench.page.points import without_shared
from dnanalyze.workbench.page.style import Palette, hover, plain_figure

LAYERS = ("measured", "Wang 2025 model", "present model", "candidate")
EMPTY: dict[str, list[float]] = {"x": [], "y": [], "low": [], "high": []}
MARGIN = 0.04  # of an axis beyond the curves, on its scale
LEFT = 58  # screen pixels to the left of both figures, so that their abscissas agree
MOST_SIGMA = 60.0  # residuals that are drawn, at most
COLOURS = {"Wang 2025 model": "wang", "present model": "present", "candidate": "candidate"}
MOST_MARKS = 12  # frequencies that a figure marks
APART = 0.04  # share of the abscissa that the names of two marks are apart at least


class CurvePlot:
    """A Bokeh figure of the layers.

    Scales, tickers and ranges of the one figure are exchanged: a second figure could be drawn over
    the first while a browser is behind.

    Parameters
    ----------
    palette : Palette
    name : str
        Prefix of the names of its data sources.
    """

    def __init__(self, palette: Palette, name: str = "curve") -> None:
        p = self._palette = palette
        self.sources = {
            layer: ColumnDataSource(dict(EMPTY), name=f"{name} of {layer}") for layer in LAYERS
        }
        self.figure = made = plain_figure(
            p, sizing_mode="stretch_both", tools="pan,wheel_zoom,box_zoom,reset",
            x_axis_label=" ", y_axis_label=" ", x_range=Range1d(0, 1), y_range=Range1d(0, 1),
            name=name, css_classes=[name],
        )  # fmt: skip
        self._axes = (_Axis(made, "x"), _Axis(made, "y"))
        looks = {
            "measured": (p.ink, "solid", 1.6),
            "Wang 2025 model": (p.wang, "8 3", 1.8),
            "present model": (p.present, "solid", 2.2),
            "candidate": (p.candidate, "2 2", 2.4),
        }
        measured = self.sources["measured"]
        self._band = made.varea(
            x="x", y1="low", y2="high", source=measured, fill_color=p.ink, fill_alpha=0.16
        )
        self._whisker = Whisker(
            source=measured, base="x", upper="high", lower="low", line_color=p.ink, visible=False
        )
        made.add_layout(self._whisker)
        self._lines, self._dots = {}, []
        for layer, (colour, dash, width) in looks.items():
            self._lines[layer] = made.line(
                "x", "y", source=self.sources[layer], color=colour, line_dash=dash,
                line_width=width, legend_label=layer, name=layer,
            )  # fmt: skip
            self._dots.append(
                made.scatter("x", "y", source=self.sources[layer], color=colour, size=6,
                             visible=False)
            )  # fmt: skip
        self._marks = ColumnDataSource({"x": [], "y": [], "text": []})
        self._spans = [
            Span(dimension="height", line_color=p.quiet, line_dash="3 3", visible=False)
            for _ in range(MOST_MARKS)
        ]
        self._box = BoxAnnotation(fill_color=p.candidate, fill_alpha=0.08, visible=False,
                                  level="underlay")  # fmt: skip
        for annotation in (*self._spans, self._box):
            made.add_layout(annotation)
        made.text("x", "y", "text", source=self._marks, text_color=p.quiet, angle=np.pi / 2,
                  text_font_size="10px", text_align="right", x_offset=11, y_offset=4)  # fmt: skip
        self._hover = hover(p, list(self._lines.values()), ("", "$name"), mode="mouse")
        made.add_tools(self._hover)
        _legend(made, p)
        self._make_residuals(name)
        self._subject: Any = None
        self._whole: list[tuple[float, float]] = []

    def _make_residuals(self, name: str) -> None:
        """A figure below on the same abscissa: by how much each model is off, in sigma."""
        p = self._palette
        self.apart = {
            layer: ColumnDataSource({"x": [], "y": []}, name=f"{name} residual of {layer}")
            for layer in LAYERS[1:]
        }
        self.residuals = made = plain_figure(
            p, sizing_mode="stretch_width", height=76, tools="", x_range=self.figure.x_range,
            y_range=Range1d(-5, 5), x_axis_label=" ", y_axis_label="Δ [σ]",
            name=f"{name} residuals", min_border_left=LEFT, css_classes=[f"{name}-residuals"],
        )  # fmt: skip
        self.figure.min_border_left = LEFT
        made.add_layout(
            BoxAnnotation(bottom=-2, top=2, fill_color=p.ink, fill_alpha=0.1, level="underlay")
        )
        for layer, source in self.apart.items():
            colour = getattr(p, COLOURS[layer])
            made.line("x", "y", source=source, color=colour, line_width=1.4)
            made.scatter("x", "y", source=source, color=colour, size=3)
        self._around = FixedTicker(ticks=ticks_around(5.0))  # a low figure has room for three
        made.yaxis.ticker = made.ygrid.ticker = self._around
        self._below = _Axis(made, "x")

    def _show_residuals(
        self, axes: Axes, labels: Sequence[str], curves: Mapping[str, Curve]
    ) -> None:
        """Of curves; over operating points the cells of the statistic state them."""
        measured, reach = curves.get("measured"), 5.0
        for layer, source in self.apart.items():
            model = curves.get(layer)
            found = (
                None if measured is None or model is None or labels
                else residual(measured, model, axes.log_y)
            )  # fmt: skip
            data: dict[str, Any] = {"x": [], "y": []}
            if found is not None:  # what is farther off lies at the end of the axis
                data = {"x": found.x, "y": np.clip(found.y, -MOST_SIGMA, MOST_SIGMA)}
                reach = max(reach, float(np.max(np.abs(data["y"]))) * 1.1)
            if not all(np.array_equal(source.data[k], data[k]) for k in data):
                source.data = data
        r = self.residuals.y_range
        if not 0.5 * r.end < reach <= r.end:  # a preview does not make the axis jump
            r.start, r.end = -reach, reach
            self._around.ticks = ticks_around(reach)
        self._below.show(axes.log_x)
        if self.residuals.xaxis[0].axis_label != axes.x:
            self.residuals.xaxis.axis_label = axes.x
        told = any(len(s.data["x"]) for s in self.apart.values())
        if self.residuals.visible != told:
            self.residuals.visible = told
        if self.figure.xaxis[0].visible == told:  # the abscissa stands below both
            self.figure.xaxis.visible = not told

    def show(
        self,
        axes: Axes,
        labels: Sequence[str],
        curves: Mapping[str, Curve],
        subject: object,
        marks: Sequence[Mark] = (),
        band: tuple[float, float] | None = None,
    ) -> None:
        """Draw curves, and only what has changed.

        Parameters
        ----------
        axes : Axes
        labels : sequence of str
            Names of the places 0, 1, ... on the abscissa; none for a continuous one.
        curves : mapping
            By layer; the others are empty.
        subject : object
            What is shown. A new one is shown whole; of the same, a zoom by the user is kept.
        marks : sequence of Mark
            Places on the abscissa.
        band : (float, float), optional
            Part of the abscissa that is shaded.
        """
        made, fresh = self.figure, subject != self._subject
        self._subject = subject
        named = without_shared(list(labels)) if labels else []
        self._axes[0].show(axes.log_x, named)
        self._axes[1].show(axes.log_y)
        for name, source in self.sources.items():
            c = curves.get(name)
            data = dict(EMPTY) if c is None else {k: getattr(c, k) for k in EMPTY}
            if not _same(source.data, data):  # a preview changes one layer: the others stay drawn
                source.data = data
        self._limit(axes, curves, len(labels), fresh)
        self._show_residuals(axes, named, curves)
        for shown, glyphs in ((not labels, [self._band]), (bool(labels), self._dots)):
            for glyph in glyphs:
                glyph.visible = shown
        self._whisker.visible = bool(labels)
        if (made.xaxis[0].axis_label, made.yaxis[0].axis_label) != (axes.x, axes.y):
            made.xaxis.axis_label, made.yaxis.axis_label = axes.x, axes.y
            self._hover.tooltips = [
                ("", "$name"),
                (axes.x.split(" [")[0], "@x{0.0000}"),
                (axes.y.split(" [")[0], "@y{0.000e}" if axes.log_y else "@y{0.000}"),
            ]
        for item in made.legend[0].items:  # an empty curve has no line in the legend
            (line,) = item.renderers
            item.visible = bool(len(line.data_source.data["x"]))
        self._mark(marks, axes.log_x)
        if band is not None:
            self._box.left, self._box.right = band
        self._box.visible = band is not None

    def _limit(self, axes: Axes, shown: Mapping[str, Curve], places: int, fresh: bool) -> None:
        """Ranges that show the curves whole, and the error bars of the measured one."""
        curves = list(shown.values())
        x = [(-0.5, places - 0.5)] if places else [_ends(c.x, axes.log_x) for c in curves]
        y = [_ends(c.y, axes.log_y) for c in curves]
        if places and "measured" in shown:  # its error bars; a band may reach down to nothing
            y.append(_ends((shown["measured"].low, shown["measured"].high), axes.log_y))
        whole = [_wide(x, axes.log_x, 0.0 if places else MARGIN), _wide(y, axes.log_y, MARGIN)]
        ranges = self.figure.x_range, self.figure.y_range
        zoomed = not fresh and any(
            not np.allclose((r.start, r.end), was, rtol=1e-6)
            for r, was in zip(ranges, self._whole, strict=True)
        )
        if self._whole and not fresh:  # a preview does not make the axes jump unless it must
            whole = [
                was if was[0] <= now[0] and was[1] >= now[1] else now
                for was, now in zip(self._whole, whole, strict=True)
            ]
        self._whole = whole
        for r, (low, high) in zip(ranges, whole, strict=True):
            if (r.reset_start, r.reset_end) != (low, high):
                r.reset_start, r.reset_end = low, high
            if not zoomed and (r.start, r.end) != (low, high):
                r.start, r.end = low, high

    def _mark(self, marks: Sequence[Mark], log: bool) -> None:
        shown = list(marks)[:MOST_MARKS]
        top = self.figure.y_range.end
        texts = _legible([m.x for m in shown], [m.text for m in shown], self._whole[0], log)
        data = {"x": [m.x for m in shown], "y": [top] * len(shown), "text": texts}
        if self._marks.data != data:
            self._marks.data = data
        for i, span in enumerate(self._spans):
            visible = i < len(shown)
            if visible and span.location != shown[i].x:
                span.location = shown[i].x
            if span.visible != visible:
                span.visible = visible


class _Axis:
    """One axis of a figure: its scale, ticks and grid, linear, logarithmic or of named places."""

    def __init__(self, figure: Any, which: str) -> None:
        self._figure, self._which = figure, which
        self._axis = figure.xaxis[0] if which == "x" else figure.yaxis[0]
        self._grid = figure.xgrid[0] if which == "x" else figure.ygrid[0]
        self._scales = {False: LinearScale(), True: LogScale()}
        self._tickers = {
            False: BasicTicker(),
            True: log_ticker(sparse=which == "y"),
        }
        self._formatters = {
            False: BasicTickFormatter(use_scientific=False),
            True: log_formatter(),
        }
        self._places = FixedTicker(ticks=[])

    def show(self, log: bool, labels: Sequence[str] = ()) -> None:
        """Set the scale, with ticks of its kind or with names of the places 0, 1, ....

        A ticker is set only where it is another one: Bokeh then searches the whole page for models
        (80 ms), at every move of a slider.
        """
        name, names = f"{self._which}_scale", dict(enumerate(labels))
        if getattr(self._figure, name) is not self._scales[log]:
            setattr(self._figure, name, self._scales[log])
        if self._axis.formatter is not self._formatters[log]:
            self._axis.formatter = self._formatters[log]
        if self._axis.major_label_overrides != names:
            self._axis.major_label_overrides = names
            self._axis.major_label_orientation = "horizontal" if len(labels) <= 6 else 0.7
        if names and self._places.ticks != list(names):
            self._places.ticks = list(names)
        ticker = self._places if names else self._tickers[log]
        for part in (self._axis, self._grid):
            if part.ticker is not ticker:
                part.ticker = ticker


def _legible(
    at: Sequence[float], texts: Sequence[str], ends: tuple[float, float], log: bool
) -> list[str]:
    """Texts of marks; none for a mark so near to one before it that they would overlap.

    Examples
    --------
    >>> from dnanalyze.workbench.page.plot import _legible
    >>> _legible([0.5, 0.25, 0.48], ["Nyquist", "period 4", "peak"], (0.01, 0.7), True)
    ['Nyquist', 'period 4', '']
    """
    scale = np.log if log else np.asarray
    places = scale(np.asarray(at, float)) / float(np.ptp(scale(np.asarray(ends, float))))
    kept: list[int] = []
    for i in range(len(places)):
        if all(abs(places[i] - places[k]) > APART for k in kept):
            kept.append(i)
    return [text if i in kept else "" for i, text in enumerate(texts)]


def ticks_around(reach: float) -> list[float]:
    """Three ticks of an axis from ``-reach`` to ``reach``, of one digit.

    Examples
    --------
    >>> from dnanalyze.workbench.page.plot import ticks_around
    >>> ticks_around(5.0), ticks_around(46.0)
    ([-5.0, 0.0, 5.0], [-40.0, 0.0, 40.0])
    """
    power = 10.0 ** np.floor(np.log10(reach))
    tick = float(power * np.floor(reach / power))
    return [-tick, 0.0, tick]


def _ends(values: Any, log: bool) -> tuple[float, float]:
    """Least and largest value that an axis can show; NaN where there is none."""
    x = np.asarray(values, float)
    x = x[np.isfinite(x) & ((x > 0) | (not log))]
    return (float(x.min()), float(x.max())) if x.size else (np.nan, np.nan)


def _wide(ends: Sequence[tuple[float, float]], log: bool, margin: float) -> tuple[float, float]:
    """A range over several others, with a margin on its scale; never empty."""
    found = np.array([e for e in ends if np.isfinite(e[0])], float)
    if not found.size:
        return (0.1, 1.0) if log else (0.0, 1.0)
    low, high = found[:, 0].min(), found[:, 1].max()
    if log:
        low, high = np.log10(low), np.log10(high)
    if high - low < 1e-9 * max(abs(low), abs(high), 1e-9):
        low, high = low - 0.5, high + 0.5
    reach = margin * (high - low)
    low, high = low - reach, high + reach
    return (float(10**low), float(10**high)) if log else (float(low), float(high))


def _same(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether two tables of a layer hold the same numbers."""
    return all(np.array_equal(one[k], other[k], equal_nan=True) for k in EMPTY)


def _legend(made: Any, p: Palette) -> None:
    """Above the plot, in one row."""
    legend = made.legend[0]
    legend.label_text_font_size = "10px"
    legend.label_text_color = p.ink
    legend.background_fill_color = p.card
    legend.background_fill_alpha = 0.75
    legend.border_line_color = None
    legend.padding = legend.margin = 3
    legend.spacing = 10
    legend.orientation = "horizontal"
    made.add_layout(legend, "above")
