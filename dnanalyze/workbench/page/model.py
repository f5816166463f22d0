"""The model: its effects along the signal chain, each with a switch and its parameters."""

from __future__ import annotations

import html
from typing import Any

import panel as pn

from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.enlarge import enlarger
from dnanalyze.workbench.page.parameters import ParameterRow, TableRow, heading
from dnanalyze.workbench.page.rest import Rest
from dnanalyze.workbench.page.style import card, inner
from dnanalyze.workbench.page.terms import plain_name
from dnanalyze.workbench.sliders import Slider

TABLE = 4  # numbers of one parameter from which they share a plot and a slider


class Model:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        p = context.palette
        self.style = [inner(p)]
        self._drawn: Any = None
        self._adopted: NoiseModel | None = None
        self._moved = ""
        self._failing = False
        self.rest = Rest(self._rested)
        self._rows: dict[str, ParameterRow] = {}
        self._tables: dict[str, TableRow] = {}
        button = {"stylesheets": self.style, "margin": 0}
        self.fit = pn.widgets.Button(name="Fit", button_type="primary", width=52, **button)
        self.fit.on_click(lambda _: context.act(context.session.fit))
        self.errors = pn.widgets.Button(name="± errors", width=64, **button)
        self.errors.on_click(lambda _: context.act(context.session.standard_errors))
        self.add_name = pn.widgets.Select(options={}, width=106, **button)
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
                "padding-top": "16px",  # the bubble of the first slider
            },
        )
        self.loading = pn.pane.HTML(
            "<div class=loading>the starting model follows from the statistics …</div>",
            stylesheets=self.style, margin=0,
        )  # fmt: skip
        self.view = pn.Column(styles=card(p), sizing_mode="stretch_both", margin=0)
        self.view.extend([
            pn.Row(
                pn.pane.HTML("<h2>Model</h2>", stylesheets=self.style, margin=(3, 6, 0, 0)),
                self.fit, self.errors, pn.layout.HSpacer(), self.add_name, self.add,
                enlarger(self.view, self.style), self.rest,
                margin=0, sizing_mode="stretch_width",
            ),
            self.loading, self.list,
        ])  # fmt: skip
        context.listeners.append(self.update)

    def update(self, what: str) -> None:
        """Draw what has changed."""
        session, draft = self.context.session, self.context.draft
        if what != "history" or session.history is None:
            return
        moved_on = draft not in (None, session.present.model)
        if not (moved_on and session.present.model == self._adopted):  # it keeps its move
            self._draw()

    def _add(self) -> None:
        name = self.add_name.value
        if name:
            self.context.act(lambda: self.context.session.add(name))

    def _draw(self) -> None:
        session = self.context.session
        model = session.present.model
        self.context.draft = None
        present = set(model.names)
        self.loading.visible = False
        names = [n for n in sorted(session.known) if n not in present]
        chosen = self.add_name.value if self.add_name.value in names else next(iter(names), None)
        self.add_name.param.update(options={plain_name(n): n for n in names}, value=chosen)
        sliders = session.sliders()
        shape = [s.parameter.name for s in sliders], tuple(model.names), tuple(session.removed)
        if shape == self._drawn:
            self._set(sliders)
            return
        self._drawn = shape
        self._rows, self._tables = {}, {}
        made: list[Any] = []
        by_effect: dict[str, list[Slider]] = {}
        for slider in sliders:
            by_effect.setdefault(slider.parameter.effect, []).append(slider)
        made += self._parameters(by_effect.pop("pedestal", []))
        for effect in model.chain:
            made.append(self._header(effect, True))
            made += self._parameters(by_effect.get(effect.name, []))
        for name in session.removed:
            if name not in present:
                made.append(self._header(session.known[name], False))
        self.context.send(self.list, made)

    def _parameters(self, sliders: list[Slider]) -> list[Any]:
        """Rows of an effect; numbers of one parameter share a name, many of them one row."""
        groups: dict[str, list[Slider]] = {}
        for slider in sliders:
            groups.setdefault(slider.parameter.group, []).append(slider)
        made = []
        for name, group in groups.items():
            if len(group) >= TABLE:
                table = TableRow(group, self.context.palette, self._move, self._pin)
                self._tables[name] = table
                made.append(table.view)
            elif len(group) > 1:
                made.append(heading(group, self.style))
                made += [self._row(s, of_point=True) for s in group]
            else:
                made.append(self._row(group[0]))
        return made

    def _set(self, sliders: list[Slider]) -> None:
        """Show other values of the same parameters."""
        groups: dict[str, list[Slider]] = {}
        for slider in sliders:
            if slider.parameter.name in self._rows:
                self._rows[slider.parameter.name].set(slider)
            else:
                groups.setdefault(slider.parameter.group, []).append(slider)
        for name, group in groups.items():
            self._tables[name].set(group)

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
            f"<details><summary><b>{html.escape(plain_name(effect.name))}</b> "
            f"<small class=quiet>{html.escape(effect.name)}</small></summary>"
            f"<div class=quiet style='font-size:11px;padding-left:10px'>"
            f"{html.escape(effect.summary)}</div>"
            f"<div style='font-size:11px;padding:2px 0 4px 10px'>{physics}<br>"
            f"<i>{html.escape(effect.formula)}</i></div></details>"
        )
        return pn.Row(
            box,
            pn.pane.HTML(text, stylesheets=self.style, margin=0, sizing_mode="stretch_width"),
            margin=(3, 0, 0, 0), sizing_mode="stretch_width",
        )  # fmt: skip

    def _row(self, slider: Slider, of_point: bool = False) -> Any:
        row = ParameterRow(slider, self.style, self._move, self._pin, of_point)
        self._rows[slider.parameter.name] = row
        return row.view

    def _pin(self, name: str, pinned: bool) -> None:
        self.context.session.pin(name, pinned)

    def _move(self, name: str, value: float) -> None:
        """A slider moves: a preview now, the full error when it rests."""
        session, context = self.context.session, self.context
        model = session.with_value(name, value, self.context.draft)
        session.moved()
        self.rest.move()
        self.context.draft, self._moved = model, name
        context.latest.ask(
            lambda: session.preview(model), self._show, lambda error: self._failed(model, error)
        )  # fmt: skip

    def _show(self, found: Any) -> None:
        if self.context.draft is None:
            return
        if self._failing:
            self._failing = False
            self.context.session.tell("")
        self.context.shown = found
        with self.context.combined():  # the browser tells of the rest after what it draws
            self.context.tell("preview")
            if found.model == self.context.draft:
                self.rest.draw()

    def _failed(self, model: NoiseModel, error: Exception) -> None:
        """Say why a model has no preview, and go back to the last one that has."""
        self._failing = True
        self.context.session.tell(f"{type(error).__name__}: {error}")
        if model != self.context.draft:  # the slider has moved on
            return
        shown = self.context.shown
        if shown is not None and shown.preview:
            self.context.draft = shown.model
            self.rest.draw()
        else:
            self._draw()

    def _rested(self) -> None:
        self._adopted = model = self.context.draft
        name = self._moved
        if model is not None:
            self.context.act(lambda: self.context.session.adopt(model, f"set {name}"))
