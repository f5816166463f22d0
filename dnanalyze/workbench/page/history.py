"""The history: the error from step to step, undo and redo, branches, and what to take away."""

from __future__ import annotations

import html
import io
from typing import Any

import panel as pn
from bokeh.models import ColumnDataSource, FixedTicker, Range1d, TapTool

from dnanalyze.report.words import number
from dnanalyze.workbench.history import History, Node, effects_apart
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.style import card, hover, inner, plain_figure

WRAP = {"flex-wrap": "wrap", "min-width": "0"}  # of a row of widgets on a narrow page
MOST = 12  # nodes of a path in the figure; the last ones
NONE = -1  # node that is compared with


class HistoryPane:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        p, session = context.palette, context.session
        style = [inner(p)]
        self._quiet = False
        self._numbers: list[int] = []
        self.source = ColumnDataSource({k: [] for k in ("x", "top", "colour", "name", "error")})
        self.figure = self._make()
        self.bars = pn.pane.Bokeh(self.figure, sizing_mode="stretch_both", margin=0, min_height=90)
        self.node = pn.widgets.Select(options={}, width=210, stylesheets=style, margin=0)
        self.node.param.watch(self._chosen, "value")
        self.name = pn.widgets.TextInput(
            placeholder="name of this step", width=110, stylesheets=style, margin=(0, 0, 0, 4)
        )
        self.name.param.watch(self._named, "value")
        self.other = pn.widgets.Select(
            options={"–": NONE}, value=NONE, width=150, stylesheets=style, margin=0
        )
        self.other.param.watch(lambda _: self._compare(), "value")
        self.comparison = pn.pane.HTML("", stylesheets=style, margin=0)
        save = {"stylesheets": style, "margin": (0, 4, 0, 0), "button_type": "default"}
        self.yaml = pn.widgets.FileDownload(
            callback=lambda: io.BytesIO(session.yaml().encode()), filename="model.yaml",
            label="Model", width=72, **save,
        )  # fmt: skip
        self.report = pn.widgets.FileDownload(
            callback=lambda: io.BytesIO(session.report().encode()), filename="report.html",
            label="Report", width=72, **save,
        )  # fmt: skip
        self.targets = pn.widgets.FileDownload(
            callback=lambda: io.BytesIO(session.targets().encode()), filename="targets.yaml",
            label="CI targets", width=84, **save,
        )  # fmt: skip
        self.recipe = pn.widgets.Select(
            options={"copy as …": "", "commands": "commands", "Python": "python"},
            value="",
            stylesheets=style,
            margin=0,
            width=110,
        )
        self.recipe.param.watch(lambda _: self._recipe(), "value")
        self.text = pn.widgets.TextAreaInput(
            value="", stylesheets=style, margin=0, sizing_mode="stretch_both", visible=False,
            max_length=1 << 20, min_height=60,
        )  # fmt: skip
        self.view = pn.Column(
            pn.Row(
                pn.pane.HTML("<h2>History</h2>", stylesheets=style, margin=(3, 8, 0, 0)),
                self.node, self.name, margin=0, styles=WRAP,
            ),
            self.bars,
            self.text,
            pn.Row(
                pn.pane.HTML("compare with", stylesheets=style, margin=(4, 4, 0, 0)),
                self.other, self.comparison, margin=0, styles=WRAP,
            ),
            pn.Row(
                self.yaml, self.report, self.targets, self.recipe, margin=(3, 0, 0, 0), styles=WRAP,
            ),
            styles=card(p), sizing_mode="stretch_both", margin=0,
        )  # fmt: skip
        context.listeners.append(self.update)

    def _make(self) -> Any:
        p = self.context.palette
        made = plain_figure(
            p, sizing_mode="stretch_both", x_range=Range1d(-0.5, 3.5), y_range=Range1d(0, 5),
            y_axis_label="model error", tools="tap",
        )  # fmt: skip
        bars = made.vbar("x", top="top", width=0.72, color="colour", source=self.source,
                         nonselection_alpha=1.0)  # fmt: skip
        made.line([-1, 1000], [1, 1], line_dash="4 3", color=p.quiet)
        made.text("x", "top", "error", source=self.source, text_align="center", y_offset=-3,
                  text_font_size="11px", text_color=p.ink, background_fill_color=p.card,
                  background_fill_alpha=0.8)  # fmt: skip
        made.xgrid.visible = False
        made.add_tools(hover(p, [bars], ("step", "@name"), ("model error", "@error")))
        made.select_one(TapTool).renderers = [bars]
        made.xaxis.ticker = FixedTicker(ticks=[])
        self.source.selected.on_change("indices", self._tapped)
        return made

    def update(self, what: str) -> None:
        """Draw what has changed."""
        history = self.context.session.history
        if what in ("history", "evaluation", "yardstick", "earlier") and history is not None:
            self._draw(history)

    def _draw(self, history: History) -> None:
        p = self.context.palette
        path = history.path()[-MOST:]
        self._numbers = [n.number for n in path]
        errors = [0.0 if n.error is None else n.error for n in path]
        self.source.selected.indices = []
        self.source.data = {
            "x": list(range(len(path))),
            "top": errors,
            "colour": [p.present if n.number == history.at else p.quiet for n in path],
            "name": [n.title for n in path],
            "error": [_error(n) or "…" for n in path],
        }
        self.figure.x_range.end = max(4, len(path)) - 0.5
        self.figure.y_range.end = 1.25 * max([*errors, 1.2])
        self.figure.xaxis.ticker.ticks = list(range(len(path)))
        self.figure.xaxis.major_label_overrides = {i: _short(n) for i, n in enumerate(path)}
        self._quiet = True
        try:
            every = {_line(n): n.number for n in history.nodes}
            self.node.options = every
            self.node.value = history.at
            self.other.options = {"–": NONE} | every
            self.name.value = history.present.name
        finally:
            self._quiet = False
        self._compare()
        self._recipe()

    def _tapped(self, attr: str, old: Any, new: list[int]) -> None:
        if new and (number := self._numbers[new[0]]) != self.context.session.present.number:
            self.context.act(lambda: self.context.session.go(number))

    def _chosen(self, event: Any) -> None:
        if not self._quiet and event.new is not None:
            self.context.act(lambda: self.context.session.go(event.new))

    def _named(self, event: Any) -> None:
        session = self.context.session
        if not self._quiet and session.history is not None:
            number = session.present.number
            self.context.act(lambda: session.name(number, event.new))

    def _compare(self) -> None:
        """Mark another node's errors beside the present ones, and say how the models differ."""
        history, node, text = self.context.session.history, None, ""
        if history is not None and self.other.value != NONE:
            node, here = history.node(self.other.value), history.present
            text = (
                f"<b>{_error(node)} → {_error(here)}</b> "
                f"{html.escape(effects_apart(node.model, here.model))}"
            )
        self.comparison.object = text
        self.context.compared = node
        self.context.later("compared")

    def _recipe(self) -> None:
        session = self.context.session
        shown = bool(self.recipe.value) and session.history is not None
        self.text.visible, self.bars.visible = shown, not shown
        if shown:
            made = session.commands() if self.recipe.value == "commands" else session.python()
            self.text.value = made


def _short(node: Node) -> str:
    title = node.title.replace("Wang 2025 model, ", "Wang 2025 ").replace("add ", "+ ")
    if title.startswith("+ baseline"):
        title = "+ baseline"
    return title if len(title) <= 16 else title[:15] + "…"


def _error(node: Node) -> str:
    """With the sign of an error that is not by the model's own yardstick."""
    if node.error is None:
        return ""
    return number(node.error) if node.exact else f"≈ {number(node.error)}"


def _line(node: Node) -> str:
    error = "" if node.error is None else f"  {_error(node)}"
    below = (
        "" if node.parent is None or node.parent == node.number - 1 else f" (from {node.parent})"
    )
    return f"{node.number} {node.title}{below}{error}"
