"""Rows of the model's parameters: one number, or a number for each operating point."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Sequence
from typing import Any

import panel as pn
from bokeh.models import (
    BasicTickFormatter,
    ColumnDataSource,
    CustomJSTickFormatter,
    FixedTicker,
    TapTool,
)

from dnanalyze.digits import number, symbol, unit_text
from dnanalyze.fitting.free_parameters import FreeParameter
from dnanalyze.workbench.page.points import unbroken
from dnanalyze.workbench.page.style import Palette, hover, inner, plain_figure
from dnanalyze.workbench.sliders import Slider, slider_name

SPAN = 4.0  # factor to either side of the present value that a logarithmic slider covers
TICKS = 200  # positions of a slider
BUBBLE = """
const at = low + tick * (high - low);
const value = log ? Math.exp(at) : at;
if (Math.abs(value) < 1e-12 * Math.max(Math.abs(low), Math.abs(high), 1e-300)) return "0";
return String(Number(value.toPrecision(4)));
"""
ZERO = 1e-12  # share of a linear parameter's range that is 0
Move = Callable[[str, float], None]
Pin = Callable[[str, bool], None]


class LiveSlider(pn.widgets.FloatSlider):
    """A slider whose moves are told at once.

    Panel waits 50 ms for further moves; here a move replaces the one that still waits for its
    preview.
    """

    _debounce = 0


class ParameterRow:
    """One number of the model: name, slider, value, standard error, pin.

    Below a `heading`, ``of_point``, its name is the operating point alone.
    """

    def __init__(
        self, slider: Slider, style: list[str], move: Move, pin: Pin, of_point: bool = False
    ) -> None:
        self._move, self._pinned, self._of_point = move, pin, of_point
        self._quiet = False
        self._value = math.nan
        self.slider = slider
        self._low, self._high = 0.0, 1.0
        self._bubble = CustomJSTickFormatter(
            args={"low": 0.0, "high": 1.0, "log": False}, code=BUBBLE
        )
        self.bar = LiveSlider(
            start=0, end=1, step=1 / TICKS, value=0.5, show_value=False, name="",
            format=self._bubble, stylesheets=style, margin=0, sizing_mode="stretch_width",
        )  # fmt: skip
        self.number = pn.widgets.TextInput(value="", width=70, stylesheets=style, margin=0)
        self.pin = pn.widgets.Toggle(name="○", width=26, margin=(0, 0, 0, 3), stylesheets=style)
        self.bar.param.watch(self._slid, "value")
        self.number.param.watch(self._typed, "value")
        self.pin.param.watch(self._pin, "value")
        self.label = pn.pane.HTML("", stylesheets=style, margin=(3, 4, 0, 14), width=98)
        self.note = pn.pane.HTML(
            "", stylesheets=style, margin=(0, 0, 2, 14), visible=False,
            sizing_mode="stretch_width", css_classes=["limits"],
        )  # fmt: skip
        self.view = pn.Column(
            pn.Row(
                self.label, self.bar, self.number, self.pin, margin=0,
                sizing_mode="stretch_width", css_classes=["parameter"],
            ),
            self.note, margin=0, sizing_mode="stretch_width",
        )  # fmt: skip
        self.set(slider)

    def set(self, slider: Slider) -> None:
        """Show another value, or another parameter, without telling anyone.

        The slider keeps its range where it stands at that value already: a handle that is being
        moved must not jump.
        """
        other = slider.parameter.name != self.slider.parameter.name or not self.label.object
        stands = slider.value == self._value and not other
        self.slider, self._value = slider, slider.value
        self._quiet = True
        try:
            if other:
                self._name(slider)
            if self.pin.value != slider.pinned or other:
                self.pin.value, self.pin.name = slider.pinned, "📌" if slider.pinned else "○"
            self._note("" if slider.se is None else f"± {number(slider.se, 2)}")
            if not stands:
                self._low, self._high = slider_range(slider)
                self._bubble.args = {
                    "low": self._low, "high": self._high, "log": slider.parameter.log
                }  # fmt: skip
                self.bar.value = self._share(slider.parameter.position(slider.value))
                self.number.value = shown_value(slider.parameter, slider.value)
        finally:
            self._quiet = False

    def _name(self, slider: Slider) -> None:
        parameter = slider.parameter
        name = html.escape(unbroken(slider.label or parameter.name))
        if self._of_point:
            name = place(name)
        else:
            name += f" <span class=quiet>{html.escape(symbol(parameter.unit))}</span>"
        self.label.object = f"<span title='{html.escape(limits(parameter))}'>{name}</span>"

    def _note(self, text: str, wrong: bool = False) -> None:
        kind = "wrong" if wrong else "quiet"
        self.note.object = f"<span class={kind}>{html.escape(text)}</span>" if text else ""
        self.note.visible = bool(text)

    def _share(self, position: float) -> float:
        return min(1.0, max(0.0, (position - self._low) / (self._high - self._low)))

    def _pin(self, event: Any) -> None:
        if not self._quiet:
            parameter = self.slider.parameter
            owner = (
                parameter.effect
                if not parameter.parameter
                else f"{parameter.effect}.{parameter.parameter}"
            )
            self._pinned(owner, event.new)

    def _slid(self, event: Any) -> None:
        if self._quiet:
            return
        parameter = self.slider.parameter
        value = parameter.plain(self._low + event.new * (self._high - self._low))
        self._quiet = True
        try:
            self.number.value = shown_value(parameter, value)
            self._note("")  # the error was that of the fitted value
        finally:
            self._quiet = False
        self._value = value
        self._move(parameter.name, value)

    def _typed(self, event: Any) -> None:
        """A value within the limits is taken; any other stays as typed, with the limits."""
        if self._quiet:
            return
        parameter = self.slider.parameter
        try:
            value = float(event.new.replace("−", "-").replace(",", ""))
        except ValueError:
            self._note(f"not a number; {limits(parameter)}", wrong=True)
            return
        if not parameter.lower <= value <= parameter.upper:
            self._note(f"not applied; {limits(parameter)}", wrong=True)
            return
        self._note("")
        if event.new != shown_value(parameter, self._value):  # as it stands: all digits are kept
            self._move(parameter.name, value)


class TableRow:
    """A parameter with a number for each operating point: a plot, and the row of one of them."""

    def __init__(
        self, sliders: Sequence[Slider], palette: Palette, move: Move, pin: Pin
    ) -> None:  # fmt: skip
        p, style = palette, [inner(palette)]
        self._at = 0
        self._sliders = list(sliders)
        self._source = ColumnDataSource({"x": [], "y": [], "where": [], "text": []})
        parameter = sliders[0].parameter
        positive = all(s.value > 0 for s in sliders)
        self.figure = made = plain_figure(
            p, sizing_mode="stretch_width", height=84, tools="tap", min_border_left=34,
            y_axis_type="log" if parameter.log and positive else "linear",
            x_range=(-0.5, len(sliders) - 0.5),
        )  # fmt: skip
        made.line(
            "x", "y", source=self._source, color=p.present, line_width=1.4,
            nonselection_line_alpha=0.6,
        )  # fmt: skip
        dots = made.scatter(
            "x", "y", source=self._source, color=p.present, size=8,
            nonselection_fill_alpha=0.5, nonselection_line_alpha=0.5,
        )  # fmt: skip
        made.add_tools(hover(p, [dots], ("", "@where"), (parameter.parameter, "@text")))
        made.select_one(TapTool).renderers = [dots]
        self._ends = made.yaxis.ticker = FixedTicker(ticks=[])
        made.ygrid.ticker = self._ends
        made.yaxis.formatter = BasicTickFormatter(use_scientific=False, precision=3)
        made.y_range.range_padding = 0.3
        every = max(1, -(-len(sliders) // 5))
        made.xaxis.ticker = FixedTicker(ticks=list(range(0, len(sliders), every)))
        made.xaxis.major_label_overrides = {i: place(s.label) for i, s in enumerate(self._sliders)}
        self.row = ParameterRow(sliders[0], style, move, pin, of_point=True)
        self.view = pn.Column(
            heading(sliders, style, "; click a dot to choose one"),
            pn.pane.Bokeh(made, margin=0, sizing_mode="stretch_width"),
            self.row.view, margin=0, sizing_mode="stretch_width",
        )  # fmt: skip
        self._source.selected.on_change("indices", self._chosen)
        self.set(sliders)

    def set(self, sliders: Sequence[Slider]) -> None:
        """Show other values of the same parameter."""
        self._sliders = list(sliders)
        self._source.data = {
            "x": list(range(len(sliders))),
            "y": [s.value for s in sliders],
            "where": [place(s.label) for s in sliders],
            "text": [
                shown_value(s.parameter, s.value) + unit_text(s.parameter.unit) for s in sliders
            ],
        }
        values = [s.value for s in sliders]
        ends = sorted({min(values), max(values)})
        if self._ends.ticks != ends:  # ticks at ratios of 2 and 5 may be none, or lie in one place
            self._ends.ticks = ends
        if self._source.selected.indices != [self._at]:
            self._source.selected.indices = [self._at]
        self.row.set(self._sliders[self._at])

    def _chosen(self, attr: str, old: Any, new: list[int]) -> None:
        if new and new[0] != self._at:
            self._at = new[0]
            self.row.set(self._sliders[self._at])


def heading(sliders: Sequence[Slider], style: list[str], hint: str = "") -> pn.pane.HTML:
    """Name and unit of a parameter with a number for each operating point."""
    parameter = sliders[0].parameter
    return pn.pane.HTML(
        f"<b>{html.escape(slider_name(parameter))}</b> <span class=quiet>"
        f"{html.escape(symbol(parameter.unit))} at {len(sliders)} operating points{hint}</span>",
        stylesheets=style, margin=(3, 0, 0, 14),
    )  # fmt: skip


def place(label: str) -> str:
    """Operating point of a label such as ``mu, 65 °C``."""
    return label.partition(", ")[2] or label


def limits(parameter: FreeParameter) -> str:
    """The values that a parameter may take."""
    return (
        f"valid: {number(parameter.lower)} to {number(parameter.upper)}{unit_text(parameter.unit)}"
    )


def shown_value(parameter: FreeParameter, value: float) -> str:
    """A value as its field shows it; 0 where it is only the rounding of one.

    Examples
    --------
    >>> from dnanalyze.fitting.free_parameters import FreeParameter
    >>> from dnanalyze.workbench.page.parameters import shown_value
    >>> shown_value(FreeParameter("e", "rho", "value", False, -1.0, 1.0, "1"), 1.1e-16)
    '0'
    """
    if not parameter.log and abs(value) < ZERO * max(
        abs(parameter.lower), abs(parameter.upper), 1.0
    ):
        return "0"
    return f"{value:.4g}"


def slider_range(slider: Slider) -> tuple[float, float]:
    """Ends of a slider on the parameter's own scale, within its bounds."""
    parameter, value = slider.parameter, slider.value
    at = parameter.position(value)
    span = min(parameter.upper - parameter.lower, 20.0)
    reach = math.log(SPAN) if parameter.log else max(abs(value), 0.05 * span)
    low, high = parameter.inside(at - reach), parameter.inside(at + reach)
    return (low, high) if high > low else (low - 0.5, high + 0.5)
