"""The verdict in words on top of the page, with the next step and the progress of a task."""

from __future__ import annotations

import html
import re
from typing import Any

import panel as pn

from dnanalyze.report.leads import worded
from dnanalyze.report.words import number
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.points import unbroken
from dnanalyze.workbench.page.style import Palette, inner
from dnanalyze.workbench.page.terms import explained, plain_name
from dnanalyze.workbench.verdict import Verdict, verdict

TICK_MS = 250  # between two readings of a task's progress
LONG = 340  # letters of a verdict from which further sentences are folded
TASKS = {
    "open": "Opening",
    "fit": "Fit",
    "add": "Adding",
    "diagnose": "Diagnosis",
    "refine": "Refinement",
    "detect": "Hidden filters",
    "standard errors": "Standard errors",
}

STATES = {
    "preview": "estimate from a window of 128 × 128 pixels",
    "full": "over the field, with the σ of the model before; that of this model follows",
    "exact": "the error that compare states",
}


class Strip:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        p, session = context.palette, context.session
        style = [inner(p) + _looks(p)]
        self._said: Verdict | None = None
        self.error = pn.pane.HTML("", stylesheets=style, margin=(0, 14, 0, 0), width=236)
        self.text = pn.pane.HTML(
            "", stylesheets=style, margin=0, sizing_mode="stretch_width", css_classes=["verdict"]
        )
        self.progress = pn.pane.HTML(
            "", stylesheets=style, margin=0, sizing_mode="stretch_width", visible=False
        )
        self.message = pn.pane.HTML(
            "", stylesheets=style, margin=0, sizing_mode="stretch_width", visible=False
        )
        button = {"stylesheets": style, "margin": (0, 0, 0, 8)}
        self.act = pn.widgets.Button(
            name="Find what is missing", button_type="primary", visible=False,
            css_classes=["next"], **button,
        )  # fmt: skip
        self.cancel = pn.widgets.Button(name="Cancel", disabled=True, **button)
        self.undo = pn.widgets.Button(name="Undo", disabled=True, **button)
        self.redo = pn.widgets.Button(name="Redo", disabled=True, **button)
        self.act.on_click(lambda _: self._do())
        self.cancel.on_click(lambda _: context.act(session.cancel))
        self.undo.on_click(lambda _: context.act(session.undo))
        self.redo.on_click(lambda _: context.act(session.redo))
        self.view = pn.Row(
            self.error,
            pn.Column(
                self.text, self.progress, self.message, margin=0, sizing_mode="stretch_width"
            ),
            self.act, self.cancel, self.undo, self.redo,
            sizing_mode="stretch_width", margin=0,
            styles={
                "background": p.card, "border": f"1px solid {p.line}", "border-radius": "6px",
                "padding": "6px 10px", "align-items": "center", "min-height": "52px",
            },
        )  # fmt: skip
        context.listeners.append(self.update)
        context.every(TICK_MS, self.tick)
        self.update("history")

    def update(self, what: str) -> None:
        """Draw what has changed."""
        self._number()
        if what in ("preview", "error"):
            return
        self._said = said = verdict(self.context.session)
        first, rest = _folded(unbroken(said.text))
        text = f"<span class='tone {said.tone}'></span>{_printed(first)}"
        if rest:
            text += f"<details><summary>more</summary>{_printed(rest)}</details>"
        if self.text.object != text:
            self.text.object = text
        label = _label(said)
        if label and self.act.name != label:
            self.act.name = label
        self.act.visible = bool(label)
        history = self.context.session.history
        if history is not None:
            self.undo.disabled = history.present.parent is None
            self.redo.disabled = not history.undone
        if what == "message":
            words = html.escape(self.context.session.message)
            self.message.object = f"<span class=message>{words}</span>" if words else ""
            self.message.visible = bool(words)
        self.tick()

    def _number(self) -> None:
        """The model error, and from where it has come."""
        shown, history = self.context.shown, self.context.session.history
        if (
            shown is None
            or history is None
            or (history.present.error is None and not shown.preview)
        ):
            text = "<span class=quiet>model error …</span>"
        else:
            about = "" if shown.exact else "≈ "
            state = "preview" if shown.preview else "exact" if shown.exact else "full"
            parent = history.present.parent
            other = history.present if shown.preview else (
                None if parent is None else history.nodes[parent]
            )  # fmt: skip
            before = None if other is None or shown.exact > other.exact else other.error
            came = f"from {number(before)}; " if before is not None else ""
            if shown.exact and history.present.before is not None:
                came = f"from {number(history.present.before)} by this σ;<br>"
            text = (
                f"<div class=number><span class='error {state}' title='{STATES[state]}'>"
                f"{about}{number(shown.error)}</span>"
                f"<span class=quiet>model error{explained('model error')}<br>{came}"
                "1 = second sensor</span></div>"
            )
        if self.error.object != text:
            self.error.object = text

    def tick(self) -> None:
        """Show how far a task is."""
        session = self.context.session
        session.fade()
        job = session.worker.job
        busy = job is not None and not job.background
        self.cancel.disabled = job is None or not job.cancellable
        self.act.disabled = busy and not (self._said and self._said.action == "add")
        text = ""
        if job is not None:
            left = session.remaining_s(job)
            value = (
                ""
                if left is None
                else f" value={job.elapsed_s:.1f} max={job.elapsed_s + left + 0.1:.1f}"
            )
            stage = html.escape(plain_stage(job.progress))
            text = f"<progress{value}></progress> {TASKS[job.task.kind]}: {stage} · "
            text += f"{job.elapsed_s:.0f} s"
            if left is not None:
                text += f", about {left:.0f} s left"
            if job.first and not job.background:
                text += f" · <span class=quiet>{html.escape(worded(job.first))}</span>"
        elif session.evaluation is None and not session.message:
            text = "<progress></progress>"
        if text != self.progress.object:
            self.progress.object = text
        self.progress.visible = bool(text)

    def _do(self) -> None:
        session, said = self.context.session, self._said
        if said is None or not said.action:
            return

        def add() -> Any:
            job = session.worker.job
            if job is not None and not job.background:  # the search goes on no further
                session.cancel()
            return session.add(said.effect)

        self.context.act(
            {"diagnose": session.diagnose, "complete": session.complete, "add": add}[said.action]
        )


def plain_stage(progress: str) -> str:
    """What a task does, with effects by their plain names.

    Examples
    --------
    >>> from dnanalyze.workbench.page.strip import plain_stage
    >>> plain_stage("trying column_fpn"), plain_stage("trying detection limits")
    ('testing Column FPN', 'detection limits')
    """
    first, _, rest = progress.partition(" ")
    if first not in ("trying", "adding"):
        return progress
    one = re.fullmatch(r"[a-z]+(_[a-z]+)+|[a-z]{3,4}", rest)
    if one is None:
        return rest
    return f"{'testing' if first == 'trying' else 'refitting with'} {plain_name(rest)}"


def _folded(text: str) -> tuple[str, str]:
    """The first sentences, of a few lines, and the others.

    Examples
    --------
    >>> from dnanalyze.workbench.page.strip import _folded
    >>> _folded("One. " * 3)
    ('One. One. One.', '')
    >>> _folded("A sentence of forty letters, or about so. " * 9)[1].count("A sentence")
    1
    """
    first, rest = "", ""
    for one in re.split(r"(?<=\.) (?=[^\Wa-z])", text.strip()):
        if rest or (first and len(first) + len(one) > LONG):
            rest = f"{rest} {one}".strip()
        else:
            first = f"{first} {one}".strip()
    return first, rest


def _printed(text: str) -> str:
    """Escaped, with the effects' names: in words, and the code name small; commands as code.

    Examples
    --------
    >>> from dnanalyze.workbench.page.strip import _printed
    >>> _printed("`dnanalyze diagnose` tests < 9 effects")
    '<code>dnanalyze diagnose</code> tests &lt; 9 effects'
    """

    def named(found: re.Match[str]) -> str:
        return f"<b>{plain_name(found[1])}</b> <small class=quiet>{found[1]}</small>"

    text = re.sub(r"`([^`]+)`", r"<code>\1</code>", html.escape(text))
    return re.sub(r"\{([a-z][a-z0-9_]*)\}", named, text)


def _label(said: Verdict) -> str:
    """Text of the button."""
    errors = ""
    if said.before is not None and said.after is not None:
        errors = f": {number(said.before)} → {number(said.after)}"
    return {
        "": "",
        "diagnose": "Find what is missing",
        "add": f"Add {plain_name(said.effect)}{errors}" if said.effect else "",
        "complete": f"Add the baseline effects{errors}",
    }[said.action]


def _looks(p: Palette) -> str:
    return f"""
.number {{ display:flex; align-items:center; gap:8px; font-size:11px; }}
.error {{ font-size:28px; line-height:1; font-weight:700; color:{p.present}; white-space:nowrap; }}
.tone {{ display:inline-block; width:10px; height:10px; border-radius:50%; margin-right:8px;
  background:{p.quiet}; }}
.tone.bad {{ background:{p.heat[4]}; }}
.tone.good {{ background:{p.good}; }}
.tone.open {{ background:{p.wang}; }}
:host(.verdict) {{ font-size:14px; line-height:1.35; text-wrap:pretty; }}
details {{ display:inline; margin-left:6px; }}
details[open] {{ display:block; margin:2px 0 0 18px; font-size:12px; }}
details > summary {{ display:inline; cursor:pointer; color:{p.present}; font-size:12px; }}
progress {{ width:120px; height:8px; accent-color:{p.present}; vertical-align:middle; }}
.message {{ color:{p.heat[5]}; font-weight:600; }}
"""
