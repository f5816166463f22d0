"""What is missing: diagnosis, refinement and detection, and the candidates that they rank."""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import panel as pn
import param
from panel.custom import JSComponent

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.model.noise_model import model_from_plain
from dnanalyze.report.leads import plain_name as in_words
from dnanalyze.report.leads import worded
from dnanalyze.report.words import number, percent
from dnanalyze.workbench.page.background import Latest
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.enlarge import enlarger
from dnanalyze.workbench.page.points import unbroken
from dnanalyze.workbench.page.style import Palette, card, inner
from dnanalyze.workbench.page.terms import plain_name

MAX_CANDIDATES = 8  # candidates shown
HINT = (  # where nothing has been asked for yet
    "<span class=quiet><i>Diagnose</i> ranks the effects that may be missing; <i>Refine</i> adds "
    "them until nothing more is missing; <i>Detect</i> looks for hidden filters.</span>"
)
TICK_MS = 250  # between two readings of a task's progress


class CandidateList(JSComponent):
    """Rows that tell when the pointer is over one and when one is added."""

    rows = param.List(default=[], doc="Mappings of texts; see candidates.js.")
    busy = param.Boolean(default=False, doc="Whether a task is under way.")
    hovered = param.String(default="")
    added = param.Event(default=False)
    effect = ""

    _esm = Path(__file__).with_name("candidates.js").read_text(encoding="utf-8")

    def _handle_msg(self, message: Any) -> None:
        if not isinstance(message, dict):
            return
        if "hover" in message:
            self.hovered = str(message["hover"])
        elif "add" in message:
            self.effect = str(message["add"])
            self.param.trigger("added")


class Missing:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        p, session = context.palette, context.session
        style = [inner(p)]
        self._models: dict[str, Any] = {}
        self._latest = Latest(context.back)
        button = {"stylesheets": style, "margin": (0, 4, 0, 0)}
        self.diagnose = pn.widgets.Button(name="Diagnose", button_type="primary", **button)
        self.refine = pn.widgets.Button(name="Refine", **button)
        self.detect = pn.widgets.Button(name="Detect", **button)
        self.diagnose.on_click(lambda _: context.act(session.diagnose))
        self.refine.on_click(lambda _: context.act(session.refine))
        self.detect.on_click(lambda _: context.act(session.detect))
        self.verdict = pn.pane.HTML(
            HINT, stylesheets=style, margin=(2, 0, 0, 0), sizing_mode="stretch_width"
        )
        self.filters = pn.pane.HTML("", stylesheets=style, margin=(2, 0, 0, 0))
        self.of = pn.pane.HTML("", stylesheets=style, margin=0)
        self.list = CandidateList(
            stylesheets=[inner(p) + _rows(p)], sizing_mode="stretch_width", margin=0
        )
        self.list.param.watch(self._hovered, "hovered")
        self.list.param.watch(lambda _: context.act(self._add), "added")
        self.notes = pn.pane.HTML("", stylesheets=style, margin=0, sizing_mode="stretch_width")
        self.view = pn.Column(styles=card(p), sizing_mode="stretch_both", margin=0)
        self.view.extend([
            pn.Row(
                pn.pane.HTML("<h2>What is missing</h2>", stylesheets=style, margin=(3, 8, 0, 0)),
                self.diagnose, self.refine, self.detect, pn.layout.HSpacer(),
                enlarger(self.view, style), margin=0, sizing_mode="stretch_width",
            ),
            self.filters, self.verdict, self.of,
            pn.Column(
                self.list, self.notes, margin=0, sizing_mode="stretch_both",
                styles={"overflow-y": "auto", "min-height": "0"},
            ),
        ])  # fmt: skip
        context.listeners.append(self.update)
        self._enable()
        context.every(TICK_MS, self._enable)

    def _add(self) -> Any:
        """Add a candidate; a search that still goes on ends."""
        session = self.context.session
        job = session.worker.job
        if job is not None and not job.background and job.task.kind == "diagnose":
            session.cancel()
        return session.add(self.list.effect)

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what == "diagnosis":
            self._diagnosed()
        elif what == "detection":
            self._detected()
        elif what == "history":
            self._aged()
        elif what == "message":
            self._enable()  # a message often tells the end of a task
            found = self.context.session.diagnosis
            if found is not None and not found["finished"]:
                self._unfinished()

    def _unfinished(self) -> None:
        rest = "goes on" if self.context.session.worker.runs("diagnose") else "was ended"
        self.verdict.object = f"<span class=loading>Candidates so far; the search {rest}.</span>"

    def _enable(self) -> None:
        job = self.context.session.worker.job
        busy = job is not None and not job.background
        for button in (self.diagnose, self.refine, self.detect):
            button.disabled = busy
        self.list.busy = busy and job is not None and job.task.kind != "diagnose"

    def _diagnosed(self) -> None:
        found = self.context.session.diagnosis
        if found is None:
            self.list.rows, self.notes.object, self.verdict.object = [], "", HINT
            return
        self._models = {c["effect"]: c["model"] for c in found["candidates"] if c["model"]}
        present = set(self.context.session.present.model.names)
        shown = found["candidates"][:MAX_CANDIDATES]
        self.list.rows = [
            {
                "effect": c["effect"],
                "name": plain_name(c["effect"]),
                "confidence": percent(c["confidence"]) if found["finished"] else "…",
                "error": number(c["error_after"]),
                "explained": max(0.0, min(1.0, c["explained"])),
                "evidence": text,
                "can_add": c["effect"] not in present,
            }
            for c, text in zip(shown, evidence(shown), strict=True)
        ]
        self._aged()
        if not found["finished"]:
            self._unfinished()
            self.notes.object = ""
            return
        words = {
            "adequate": "Adequate: no missing effect is detectable in these captures.",
            "missing": "An effect is missing.",
            "unexplained": "Unexplained: no effect of the catalogue accounts for the residual.",
        }
        self.verdict.object = f"<b>{words[found['verdict']]}</b>"
        parts = []
        if found["unexplained"]:
            titles = [infos()[name].title for name in found["unexplained"]]
            parts.append(_details("Statistics not explained", titles))
        if found["next_capture"]:
            parts.append(_details("Recommended captures", found["next_capture"]))
        if found["detection_limits"]:
            parts.append(_details("Detection limits", list(found["detection_limits"].values())))
        self.notes.object = "".join(parts)

    def _aged(self) -> None:
        """Say of which model the candidates are, where it is not the present one."""
        session = self.context.session
        found, history = session.diagnosis, session.history
        if found is None or history is None or not self.list.rows:
            return
        if found["node"] == history.at:
            self.of.object = ""
            return
        node = history.node(found["node"])
        self.of.object = (
            f"<span class=quiet>diagnosis of step {node.number}, {html.escape(node.title)}</span>"
        )
        if self.context.candidate is not None:
            self.context.candidate = None
            self.context.tell("candidate")
        present = set(history.present.model.names)
        self.list.rows = [r | {"can_add": r["effect"] not in present} for r in self.list.rows]
        self.verdict.object = ""

    def _detected(self) -> None:
        found = self.context.session.detection
        if found is None:
            return
        kind = found["kind"] if found["filtered"] else "no filter found"
        rows = [
            f"{f['test']} ({f['kind']}): p = {f['p_value']:.2g}, effect {f['effect_size']:.2g}"
            f"{', flagged' if f['flagged'] else ''}"
            for f in found["findings"]
            if f["p_value"] is not None
        ]
        self.filters.object = (
            f"<b>Hidden filters: {html.escape(kind)}</b>"
            + _details("Tests", rows)
            + _details("Not determined", [str(x) for x in found.get("ambiguous", [])])
        )

    def _hovered(self, event: Any) -> None:
        """The predicted curve of the candidate under the pointer."""
        context, session = self.context, self.context.session
        plain = self._models.get(event.new)
        if plain is None:
            context.candidate = None
            context.later("candidate")
            return

        def work() -> Any:
            return session.preview(model_from_plain(plain, "model", session.known))

        def show(found: Any) -> None:
            if self.list.hovered == event.new:
                context.candidate = event.new, found
                context.tell("candidate")

        self._latest.ask(work, show, lambda error: session.tell(str(error)))


def evidence(candidates: Sequence[Any]) -> list[str]:
    """The most telling evidence of each candidate, and what it is confounded with.

    Effects that every sensor has are added together, and the same statistic tells of them: it is
    stated of the first.
    """
    said: dict[str, str] = {}
    texts = []
    for c in candidates:
        name, first = in_words(c["effect"]), c["evidence"][0] if c["evidence"] else ""
        text = unbroken(worded(first))
        misfit = text.partition("; with ")[0]
        if misfit in said:
            text = f"evidence as for {said[misfit]}"
        elif misfit:
            said[misfit] = name
        others = ", ".join(map(in_words, c["confused_with"]))
        texts.append(" · ".join(t for t in (text, others and f"confounded with {others}") if t))
    return texts


def _details(title: str, rows: list[str]) -> str:
    if not rows:
        return ""
    items = "".join(f"<li>{html.escape(str(r))}</li>" for r in rows)
    return f"<details><summary>{title} ({len(rows)})</summary><ul>{items}</ul></details>"


def _rows(p: Palette) -> str:
    return f"""
.row {{ border-top:1px solid {p.line}; padding:3px 2px; }}
.row:hover {{ background:{p.background}; }}
.head {{ display:grid; grid-template-columns:minmax(0, 1fr) 76px 64px 46px; align-items:baseline;
  text-align:right; }}
.name {{ font-weight:650; text-align:left; }}
.number {{ font-variant-numeric:tabular-nums; color:{p.quiet}; }}
.head button {{ justify-self:end; }}
.bar {{ height:4px; background:{p.line}; margin:2px 0; border-radius:2px; }}
.bar span {{ display:block; height:100%; background:{p.candidate}; border-radius:2px; }}
.evidence {{ color:{p.quiet}; font-size:11px; }}
button {{ font:inherit; border:1px solid {p.line}; border-radius:4px; background:{p.present};
  color:{p.card}; padding:0 10px; cursor:pointer; }}
button:disabled {{ opacity:.45; cursor:default; }}
"""
