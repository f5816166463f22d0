"""The model: its effects along the signal chain, each with a switch and its parameters."""

from __future__ import annotations

import html
import math
from typing import Any

import panel as pn

from dnanalyze.digits import number, symbol
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.style import card, inner
from dnanalyze.workbench.session import Slider

REST_S = 0.2  # without a move after a preview is drawn, after which the full error is computed
SPAN = 4.0  # factor to either side of the present value that a logarithmic slider covers
TICKS = 200  # positions of a slider


class Model:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        p = context.palette
        self.style = [inner(p)]
        self._drawn: Any = None
        self._draft: NoiseModel | None = None
        self._moved = ""
        self._failing = False
        self._resting: Any = None
        self._rows: dict[str, ParameterRow] = {}
        button = {"stylesheets": self.style, "margin": 0}
        self.fit = pn.widgets.Button(name="Fit", button_type="primary", width=52, **button)
        self.fit.on_click(lambda _: context.act(context.session.fit))
        self.errors = pn.widgets.Button(name="± errors", width=68, **button)
        self.errors.on_click(lambda _: context.act(context.session.standard_errors))
        self.add_name = pn.widgets.Select(options=[], width=120, **button)
        self.add = pn.widgets.Button(name="Add", width=50, **button)
        self.add.on_click(lambda _: self._add())
        self.list = pn.Column(
            margin=0,
            sizing_mode="stretch_both",
            styles={
                "overflow-y": "auto",
                "overflow-x": "hidden",
                "min-height": "0",
                "padding-right": "4px",
                "margin-top": "4px",
            },
        )
        self.view = pn.Column(
            pn.Row(
                pn.pane.HTML("<h2>Model</h2>", stylesheets=self.style, margin=(3, 6, 0, 0)),
                self.fit, self.errors, pn.layout.HSpacer(), self.add_name, self.add,
                margin=0, sizing_mode="stretch_width",
            ),
            self.list,
            styles=card(p), sizing_mode="stretch_both", margin=0,
        )  # fmt: skip
        context.listeners.append(self.update)

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what == "history" and self.context.session.history is not None:
            self._draw()

    def _add(self) -> None:
        name = self.add_name.value
        if name:
            self.context.act(lambda: self.context.session.add(name))

    def _draw(self) -> None:
        session = self.context.session
        model = session.present.model
        self._draft = None
        present = set(model.names)
        self.add_name.options = [n for n in sorted(session.known) if n not in present]
        sliders = session.sliders()
        shape = [(s.knob.name, s.pinned) for s in sliders], tuple(model.names)
        if shape == self._drawn:
            for slider in sliders:
                self._rows[slider.knob.name].set(slider)
            return
        self._drawn = shape
        self._rows = {}
        made: list[Any] = []
        by_effect: dict[str, list[Slider]] = {}
        for slider in sliders:
            by_effect.setdefault(slider.knob.effect, []).append(slider)
        for slider in by_effect.pop("pedestal", []):
            made.append(self._row(slider))
        for effect in model.chain:
            made.append(self._header(effect, True))
            made += [self._row(s) for s in by_effect.get(effect.name, [])]
        for name in session.removed:
            if name not in present:
                made.append(self._header(session.known[name], False))
        self.list.objects = made

    def _header(self, effect: Any, present: bool) -> Any:
        session = self.context.session
        box = pn.widgets.Checkbox(
            value=present, name="", stylesheets=self.style, margin=(3, 2, 0, 0), width=16
        )

        def switched(event: Any) -> None:
            act = session.restore if event.new else session.remove
            self.context.act(lambda: act(effect.name))

        box.param.watch(switched, "value")
        physics = html.escape(" ".join(effect.physics.split()) or effect.summary)
        text = (
            f"<details><summary><b>{html.escape(effect.name)}</b> "
            f"<span class=quiet>{html.escape(effect.summary)}</span></summary>"
            f"<div style='font-size:11px;padding:2px 0 4px 10px'>{physics}<br>"
            f"<i>{html.escape(effect.formula)}</i></div></details>"
        )
        return pn.Row(
            box,
            pn.pane.HTML(text, stylesheets=self.style, margin=0, sizing_mode="stretch_width"),
            margin=(3, 0, 0, 0), sizing_mode="stretch_width",
        )  # fmt: skip

    def _row(self, slider: Slider) -> Any:
        row = ParameterRow(slider, self.style, self._move, self._pin)
        self._rows[slider.knob.name] = row
        return row.view

    def _pin(self, name: str, pinned: bool) -> None:
        self.context.session.pin(name, pinned)

    def _move(self, name: str, value: float) -> None:
        """A slider moves: a preview now, the full error when it rests."""
        session, context = self.context.session, self.context
        model = session.with_value(name, value, self._draft)
        self._draft, self._moved = model, name
        context.latest.ask(
            lambda: session.preview(model), self._show, lambda error: self._failed(model, error)
        )  # fmt: skip
        self._wait(None)

    def _wait(self, seconds: float | None) -> None:
        """Begin the wait for the slider's rest anew; None: after the next preview."""
        document = self.context.document
        if self._resting is not None:
            document.remove_timeout_callback(self._resting)
        self._resting = (
            None if seconds is None
            else document.add_timeout_callback(self._rested, int(1000 * seconds))
        )  # fmt: skip

    def _show(self, found: Any) -> None:
        if self._draft is None:
            return
        if self._failing:
            self._failing = False
            self.context.session.tell("")
        self.context.shown = found
        self.context.tell("preview")
        if found.model == self._draft:
            self._wait(REST_S)

    def _failed(self, model: NoiseModel, error: Exception) -> None:
        """Say why a model has no preview, and go back to the last one that has."""
        self._failing = True
        self.context.session.tell(f"{type(error).__name__}: {error}")
        if model != self._draft:  # the slider has moved on
            return
        shown = self.context.shown
        if shown is not None and shown.preview:
            self._draft = shown.model
            self._wait(REST_S)
        else:
            self._draw()

    def _rested(self) -> None:
        self._resting = None
        model, name = self._draft, self._moved
        if model is not None:
            self.context.act(lambda: self.context.session.adopt(model, f"set {name}"))


class LiveSlider(pn.widgets.FloatSlider):
    """A slider whose moves are told at once.

    Panel waits 50 ms for further moves; here a move replaces the one that still waits for its
    preview.
    """

    _debounce = 0


class ParameterRow:
    """One parameter: name, slider, number with unit, pin."""

    def __init__(self, slider: Slider, style: list[str], move: Any, pin: Any) -> None:
        self.slider = slider
        self._move = move
        self._quiet = False
        self._value = math.nan
        knob = slider.knob
        label = slider.label or knob.name
        unit = (
            f" <span class=quiet>{html.escape(symbol(knob.unit))}</span>"
            if symbol(knob.unit)
            else ""
        )
        tip = f"{knob.lower:.4g} to {knob.upper:.4g} {knob.unit}".strip()
        name = f"<span title='{html.escape(tip)}'>{html.escape(label)}{unit}</span>"
        self.bar = LiveSlider(
            start=0, end=1, step=1 / TICKS, value=0.5, show_value=False, name="",
            stylesheets=style, margin=0, sizing_mode="stretch_width",
        )  # fmt: skip
        self.number = pn.widgets.TextInput(value="", width=66, stylesheets=style, margin=0)
        self.pin = pn.widgets.Toggle(
            name="📌" if slider.pinned else "○", value=slider.pinned, width=26, margin=0,
            stylesheets=style,
        )  # fmt: skip
        self.bar.param.watch(self._slid, "value")
        self.number.param.watch(self._typed, "value")
        owner = knob.effect if not knob.parameter else f"{knob.effect}.{knob.parameter}"
        self.pin.param.watch(lambda e: pin(owner, e.new), "value")
        self.error = pn.pane.HTML("", stylesheets=style, margin=(4, 2, 0, 3), width=54)
        self.view = pn.Row(
            pn.pane.HTML(name, stylesheets=style, margin=(3, 0, 0, 18), width=112),
            self.bar, self.number, self.error, self.pin,
            margin=0, sizing_mode="stretch_width", height=26, css_classes=["parameter"],
        )  # fmt: skip
        self.set(slider)

    def set(self, slider: Slider) -> None:
        """Show another value without telling anyone.

        The slider keeps its range where it stands at that value already: a handle that is being
        moved must not jump.
        """
        stands = slider.value == self._value
        self.slider, self._value = slider, slider.value
        self.error.object = (
            "" if slider.se is None else f"<span class=quiet>± {number(slider.se, 2)}</span>"
        )
        if stands:
            return
        self._low, self._high = _range(slider)
        self._quiet = True
        try:
            self.bar.value = self._share(slider.knob.position(slider.value))
            self.number.value = f"{slider.value:.4g}"
        finally:
            self._quiet = False

    def _share(self, position: float) -> float:
        return min(1.0, max(0.0, (position - self._low) / (self._high - self._low)))

    def _slid(self, event: Any) -> None:
        if self._quiet:
            return
        knob = self.slider.knob
        value = knob.plain(self._low + event.new * (self._high - self._low))
        self._quiet = True
        try:
            self.number.value = f"{value:.4g}"
            self.error.object = ""  # it was that of the fitted value
        finally:
            self._quiet = False
        self._value = value
        self._move(knob.name, value)

    def _typed(self, event: Any) -> None:
        if self._quiet:
            return
        try:
            value = float(event.new)
            if not math.isfinite(value):
                raise ValueError
        except ValueError:
            self.set(self.slider)
            return
        self._move(self.slider.knob.name, value)


def _range(slider: Slider) -> tuple[float, float]:
    """Ends of a slider on the parameter's own scale, within its bounds."""
    knob, value = slider.knob, slider.value
    at = knob.position(value)
    reach = math.log(SPAN) if knob.log else max(abs(value), 0.05 * _span(knob.lower, knob.upper))
    low, high = knob.inside(at - reach), knob.inside(at + reach)
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _span(low: float, high: float) -> float:
    return min(high - low, 20.0)
