"""The history: the error from step to step, undo and redo, branches, and what to take away."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import panel as pn
import param
from panel.custom import JSComponent
from PIL import Image

from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.report.leads import worded
from dnanalyze.report.words import number
from dnanalyze.workbench import exports, frames
from dnanalyze.workbench.history import History, Node, effects_apart
from dnanalyze.workbench.page.background import Latest
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.style import Palette, card, inner
from dnanalyze.workbench.session import WorkbenchSession
from dnanalyze.workbench.worst import worst_view

# Of a row of widgets on a narrow page
WRAP = {"flex-wrap": "wrap", "min-width": "0", "align-items": "center"}
LINK = ".bk-btn a { padding:0 !important; }"  # within a button that has its padding
NONE = -1  # node that is compared with


class HistoryTree(JSComponent):
    """Steps as cards that tell when one is chosen."""

    nodes = param.List(default=[], doc="Mappings of texts and places; see history.js.")
    chosen = param.Integer(default=NONE)

    _esm = Path(__file__).with_name("history.js").read_text(encoding="utf-8")

    def _handle_msg(self, message: Any) -> None:
        if isinstance(message, dict) and isinstance(message.get("go"), int):
            self.chosen = message["go"]
            self.param.trigger("chosen")


class HistoryPane:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        p, session = context.palette, context.session
        style = [inner(p)]
        self._quiet = False
        self._images: dict[NoiseModel, str] = {}
        self._latest = Latest(context.back)
        self.tree = HistoryTree(
            stylesheets=[inner(p) + _looks(p)], sizing_mode="stretch_both", margin=(4, 0),
            min_height=74,
        )  # fmt: skip
        self.tree.param.watch(self._tapped, "chosen")
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

        def download(
            made: Callable[[WorkbenchSession], str], filename: str, label: str, width: int
        ) -> pn.widgets.FileDownload:
            return pn.widgets.FileDownload(
                callback=lambda: io.BytesIO(made(session).encode()), filename=filename,
                label=label, width=width, stylesheets=[*style, LINK], margin=(0, 4, 0, 0),
                button_type="default",
            )  # fmt: skip

        self.yaml = download(exports.model_file, "model.yaml", "Model", 72)
        self.report = download(exports.report, "report.html", "Report", 72)
        self.targets = download(exports.targets, "targets.yaml", "CI targets", 84)
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
            self.tree,
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

    def update(self, what: str) -> None:
        """Draw what has changed."""
        history = self.context.session.history
        if what in ("history", "evaluation", "yardstick", "earlier") and history is not None:
            self._draw(history)

    def _draw(self, history: History) -> None:
        self._draw_tree(history)
        self._picture(history)
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

    def _draw_tree(self, history: History) -> None:
        places = history.laid_out()
        self.tree.nodes = [
            {
                "number": n.number,
                "parent": n.parent,
                "depth": places[n.number][0],
                "lane": places[n.number][1],
                "title": _short(n),
                "error": _error(n) or "…",
                "tip": f"{worded(n.title)}: model error {_error(n) or 'being computed'}",
                "present": n.number == history.at,
                "image": self._images.get(n.model, ""),
            }
            for n in history.nodes
        ]

    def _picture(self, history: History) -> None:
        """Simulate the small picture of a step that has none, one after the other."""
        session = self.context.session
        missing = next((n.model for n in history.nodes if n.model not in self._images), None)
        if missing is None or session.evaluation is None:
            return
        view = worst_view(session.evaluation.rows, session.captures)
        setting = 0 if view is None else view.setting

        def work() -> str:
            ends = frames.contrast([session.pictures.thumbnail(setting, None)])
            return _png(session.pictures.thumbnail(setting, missing), *ends)

        def show(found: str) -> None:
            now = session.history
            if now is not None:
                kept = {n.model for n in now.nodes}
                self._images = {
                    m: i for m, i in [*self._images.items(), (missing, found)] if m in kept
                }
                self._draw_tree(now)
                self._picture(now)

        self._latest.ask(work, show, lambda _: show(""))  # what raises is told with the error

    def _tapped(self, event: Any) -> None:
        history = self.context.session.history
        if history is not None and 0 <= event.new < len(history.nodes) and event.new != history.at:
            self.context.act(lambda: self.context.session.go(event.new))

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
        if node != self.context.compared:
            self.context.compared = node
            self.context.later("compared")

    def _recipe(self) -> None:
        session = self.context.session
        shown = bool(self.recipe.value) and session.history is not None
        self.text.visible, self.tree.visible = shown, not shown
        if shown:
            made = session.commands() if self.recipe.value == "commands" else session.python()
            self.text.value = made


def _short(node: Node) -> str:
    title = node.title.replace("Wang 2025 model, ", "Wang 2025 ").replace("add ", "+ ")
    if title.startswith("+ baseline"):
        title = "+ baseline"
    return worded(title)


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
    return f"{node.number} {worded(node.title)}{below}{error}"


def _png(image: np.ndarray, low: float, high: float) -> str:
    """A grey picture as an address."""
    grey = np.clip((image - low) / (high - low), 0.0, 1.0) * 255.0
    out = io.BytesIO()
    Image.fromarray(np.nan_to_num(grey).astype(np.uint8)).save(out, "PNG")
    return f"data:image/png;base64,{base64.b64encode(out.getvalue()).decode()}"


def _looks(p: Palette) -> str:
    return f"""
.tree {{ overflow:auto; height:100%; }}
svg {{ position:absolute; inset:0; }}
path {{ fill:none; stroke:{p.quiet}; stroke-width:1.2; }}
.step {{ position:absolute; display:flex; gap:7px; align-items:center; text-align:left; padding:4px;
  font:inherit; font-size:11px; line-height:1.2; color:{p.ink}; background:{p.background};
  border:1px solid {p.line}; border-radius:5px; cursor:pointer; overflow:hidden; }}
.step.present {{ border:2px solid {p.present}; padding:3px; }}
.step:focus-visible {{ outline:2px solid {p.present}; outline-offset:1px; }}
.step img {{ width:68px; height:51px; object-fit:cover; image-rendering:pixelated;
  border-radius:2px; flex:none; }}
.text {{ display:flex; flex-direction:column; gap:2px; min-width:0; }}
.title {{ display:-webkit-box; -webkit-line-clamp:2; -webkit-box-orient:vertical;
  overflow:hidden; }}
.size {{ font-size:14px; font-weight:650; font-variant-numeric:tabular-nums; }}
"""
