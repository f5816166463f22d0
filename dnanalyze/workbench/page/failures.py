"""Where the model fails: families, statistics by operating point, and the figure of one."""

from __future__ import annotations

import html
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import panel as pn
import param
from matplotlib.figure import Figure
from panel.custom import JSComponent

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.digits import minus, number, symbol
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.report.figures.heatmap import draw_families, draw_heatmap
from dnanalyze.report.leads import worded
from dnanalyze.report.words import family_title
from dnanalyze.workbench.curves import Address
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.downloads import downloads
from dnanalyze.workbench.page.enlarge import enlarger
from dnanalyze.workbench.page.figure import CurveFigure
from dnanalyze.workbench.page.points import labelled, unbroken, without_shared
from dnanalyze.workbench.page.style import Palette, card, inner
from dnanalyze.workbench.page.terms import explained, with_term
from dnanalyze.workbench.worst import worst_row

MOST_ROWS = 14  # statistics of a family in the matrix, the worst first
LEAST, MOST = 0.3, 300.0  # ends of the axis of errors
COLOUR_STEPS = (1.0, 2.0, 4.0, 10.0, 30.0)  # |difference| in sigma at which the colour changes
GOOD = 1.3  # error up to which a family is as close as a second sensor
TALL = "clamp(204px, 22vh, 420px)"  # of families and statistics: the figure has the rest
LOW = (  # of a low screen, so that the axes of the figure are on it
    "@media (max-height:840px) { :host { max-height:154px; } .families { gap:0; } "
    ".family { min-height:15px; padding:1px 4px; font-size:11px; line-height:1.2; } }"
)
LARGE = "@container (min-height:700px) { :host { max-height:40cqh; } }"  # of an enlarged pane
NOTHING = 1e-9  # share of the larger of two numbers, below which the other is 0


class FailureTable(JSComponent):
    """Bars of families and cells of statistics; it tells which one is clicked."""

    families = param.List(default=[], doc="Mappings of texts; see failures.js.")
    rows = param.List(default=[], doc="One a statistic.")
    columns = param.List(default=[], doc="Labels of the operating points.")
    corner = param.String(default="", doc="HTML at the head of the statistics.")
    one = param.Number(default=0.0, doc="Place of the error 1 on a bar, per cent.")
    clicked = param.Dict(default={}, doc="The family or the cell clicked last.")

    _esm = Path(__file__).with_name("failures.js").read_text(encoding="utf-8")

    def _handle_msg(self, message: Any) -> None:
        if isinstance(message, dict):
            self.clicked = message
            self.param.trigger("clicked")


class Failures:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        p = context.palette
        style = [inner(p)]
        self._names: list[str] = []
        self._own = False  # whether the user has chosen a statistic
        self._addresses: dict[str, Address] = {}  # by the key that a cell sends
        self._rows_of: list[dict[str, Any]] = []
        self.table = FailureTable(
            one=_place_of(1.0), stylesheets=[inner(p) + _looks(p)], sizing_mode="stretch_width",
            margin=(2, 0, 0, 0), css_classes=["failures"],
        )  # fmt: skip
        self.table.param.watch(lambda e: context.back(lambda: self._clicked(e.new)), "clicked")
        self.figure = CurveFigure(context)
        self.title = pn.pane.HTML("<h2>Where it fails</h2>", stylesheets=style, margin=0)
        self.loading = pn.pane.HTML(
            "<div class=loading>statistics of the captures …</div>", stylesheets=style, margin=0
        )
        self.view = pn.Column(
            styles=card(p) | {"overflow": "auto", "container-type": "size"},
            sizing_mode="stretch_both",
            margin=0,
        )
        self.view.extend([
            pn.Row(
                self.title, pn.layout.HSpacer(),
                *downloads(
                    "model_error", self._table, self._picture, style,
                    "families and statistics",
                ),
                enlarger(self.view, style),
                margin=0, sizing_mode="stretch_width",
            ),
            self.loading, self.table, self.figure.view,
        ])  # fmt: skip
        context.listeners.append(self.update)

    def _clicked(self, message: dict[str, Any]) -> None:
        context, self._own = self.context, True
        if (family := message.get("family")) in self._names and family != context.family:
            context.family, context.address = str(family), None
            self._draw_families()
            self._draw_matrix()
        elif (address := self._addresses.get(str(message.get("cell")))) is not None:
            context.address = context.brushed = address
            context.tell("address")
            context.tell("brush")

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what in ("evaluation", "yardstick"):
            self._follow()
        if what in ("evaluation", "yardstick", "earlier", "preview", "compared"):
            self._draw_families()
        if what in ("evaluation", "yardstick"):
            self._draw_matrix()
        if what == "address":
            self._draw_cells()
        if what == "diagnosis":
            self._lead()

    def _follow(self) -> None:
        """Show the worst cell of the first models, until the user has chosen one."""
        session, context = self.context.session, self.context
        history, evaluation = session.history, session.evaluation
        if self._own or history is None or evaluation is None or history.at > 1:
            return
        found = session.diagnosis
        if found is None or found["node"] != history.at:
            context.family, context.address = family_of_worst(evaluation.rows), None

    def _lead(self) -> None:
        """Show the statistic that tells most of the effect that a diagnosis names."""
        session, context = self.context.session, self.context
        found, history = session.diagnosis, session.history
        if found is None or history is None or session.evaluation is None or self._own:
            return
        if found["node"] != history.at or not found["candidates"]:
            return
        others = [c["effect"] for c in found["candidates"] if c["effect"] not in found["ordinary"]]
        effect = session.known.get(others[0]) if others else None
        row = worst_row(session.evaluation.rows, effect.fingerprint) if effect else None
        if row is None:
            return
        context.family, context.address = row["family"], Address(row["name"], *_place(row))
        self._draw_families()
        self._draw_matrix()
        context.tell("address")

    def _draw_families(self) -> None:
        shown, session = self.context.shown, self.context.session
        if shown is None or session.evaluation is None:
            return
        self.loading.visible = False
        if not shown.preview or not self._names:
            self._names = sorted(shown.families, key=lambda name: -shown.families[name])
        if self.context.family not in self._names:
            self.context.family = family_of_worst(session.evaluation.rows)
        marked, families = self._marked()
        made = []
        for name in self._names:
            error, mark = shown.families.get(name, np.nan), families.get(name, np.nan)
            made.append(
                {
                    "name": name,
                    "title": family_title(name),
                    "error": number(error, 3),
                    "width": _place_of(error),
                    "mark": None if np.isnan(mark) else _place_of(mark),
                    "good": bool(error <= GOOD),
                    "chosen": name == self.context.family,
                    "tip": f"{family_title(name)}: model error {number(error)}"
                    + ("" if np.isnan(mark) else f"; {marked}: {number(mark)}"),
                }
            )
        self.table.families = made
        legend = legend_of(marked, families, self.context.palette)
        text = (
            f"<h2>Where it fails {explained('family')} "
            f"<span style='font-weight:400;font-size:11px' class=quiet>"
            f"{legend}{self._share()}</span></h2>"
        )
        if self.title.object != text:
            self.title.object = text

    def _share(self) -> str:
        """How many operating points are compared, where a design leaves some out."""
        whole = len(self.context.session.captures.settings)
        points = len({_place(r)[0] for r in self._rows()})
        return f" · {points} of {whole} operating points compared" if points < whole else ""

    def _marked(self) -> tuple[str, Mapping[str, float]]:
        """Name and families' errors of the model that the marks show."""
        node, wang = self.context.compared, self.context.session.baseline
        if node is not None:
            return worded(node.title), node.families
        return "Wang 2025 model", wang.families if wang else {}

    def _draw_matrix(self) -> None:
        """The worst statistics of the chosen family; the worst cell is chosen, where none is."""
        evaluation, context = self.context.session.evaluation, self.context
        if evaluation is None or context.family not in evaluation.families:
            return
        rows = [r for r in evaluation.rows if r["family"] == context.family]
        worst: dict[str, float] = {}
        for r in rows:
            worst[r["name"]] = max(worst.get(r["name"], 0.0), abs(r["discrepancy"]))
        names = sorted(worst, key=lambda n: -worst[n])[:MOST_ROWS]
        self._rows_of = [r for name in names for r in rows if r["name"] == name]
        self._addresses = {_key(r): Address(r["name"], *_place(r)) for r in self._rows_of}
        if context.address not in self._addresses.values() and self._rows_of:
            farthest = max(self._rows_of, key=lambda r: abs(float(r["discrepancy"])))
            context.address = self._addresses[_key(farthest)]
            context.tell("address")
        else:
            self._draw_cells()

    def _draw_cells(self) -> None:
        context, known = self.context, infos()
        order = {s.point: n for n, s in enumerate(context.session.captures.settings)}
        points = list(dict.fromkeys(_place(r) for r in self._rows_of))
        points.sort(key=lambda place: order.get(place[0], len(order)))
        made: dict[str, dict[str, Any]] = {}
        for r in self._rows_of:
            title = known[r["name"]].title
            row = made.setdefault(
                r["name"],
                {
                    "title": with_term(unbroken(title)),
                    "cells": [None] * len(points),
                },
            )
            chosen = self._addresses[_key(r)] == context.address
            row["cells"][points.index(_place(r))] = _cell(r, chosen, context.palette)
        self.table.columns = without_shared([labelled(*p) for p in points])
        self.table.corner = "(measured − model) / σ" + explained("sigma")
        self.table.rows = list(made.values())

    def _rows(self) -> list[dict[str, Any]]:
        """Statistics of the model whose full error is known."""
        evaluation = self.context.session.evaluation
        return [] if evaluation is None else evaluation.rows

    def _table(self) -> pd.DataFrame:
        return pd.DataFrame(self._rows())

    def _picture(self) -> Figure:
        """The families' errors, and the statistics of the chosen family."""
        evaluation = self.context.session.evaluation
        rows = [r for r in self._rows() if r["family"] == self.context.family]
        made = Figure(figsize=(11, 6), layout="constrained")
        if evaluation is not None and rows:
            left, right = made.subplots(1, 2, width_ratios=(2, 3))
            draw_families(left, evaluation.families, {}, evaluation.error)
            draw_heatmap(right, rows, MOST_ROWS)
        return made


def legend_of(marked: str, families: Mapping[str, float], p: Palette) -> str:
    """Whose errors the marks are; nothing where there are none, as for a model of the user's."""
    return f"<span style='color:{p.wang}'>▌</span>{html.escape(marked)}" if families else ""


def family_of_worst(rows: list[dict[str, Any]]) -> str:
    """Family of the statistic that is farthest off at one operating point."""
    return str(max(rows, key=lambda r: min(abs(r["discrepancy"]), 1e4))["family"])


def _key(row: dict[str, Any]) -> str:
    """What a cell sends when it is clicked: its own statistic and place, whatever is drawn next."""
    return f"{row['name']} {labelled(*_place(row))}"


def _cell(row: dict[str, Any], chosen: bool, p: Palette) -> dict[str, Any]:
    z = float(row["discrepancy"])
    measured, model = plain_pair(row["measured"], row["simulated"])
    unit = symbol(row["unit"])
    text = f"{z:.0f}" if abs(z) >= 9.95 else f"{z:.1f}"
    text = "0" if float(text) == 0 else minus(text)
    return {
        "z": text,
        "colour": p.heat[int(np.searchsorted(COLOUR_STEPS, abs(z)))],
        "ink": "#ffffff" if abs(z) > COLOUR_STEPS[-2] else p.ink,
        "tip": f"{labelled(*_place(row))}\nmeasured {measured} {unit}\nmodel {model} {unit}\n"
        f"difference {text} σ",
        "key": _key(row),
        "chosen": chosen,
    }


def plain_pair(measured: Any, model: Any) -> tuple[str, str]:
    """Two numbers to compare; 0 for what is only the rounding of the other.

    Examples
    --------
    >>> from dnanalyze.workbench.page.failures import plain_pair
    >>> plain_pair(0.25, 1.11e-16)
    ('0.25', '0')
    """
    least = NOTHING * max(abs(measured), abs(model))
    one, other = (number(0.0 if abs(x) <= least else x, 4) for x in (measured, model))
    return one, other


def _place_of(error: float) -> float:
    """Place of an error on a bar, per cent of its length, on a log scale."""
    inside = float(np.clip(np.nan_to_num(error, nan=LEAST), LEAST, MOST))
    return round(float(100 * np.log(inside / LEAST) / np.log(MOST / LEAST)), 1)


def _place(row: Any) -> tuple[OperatingPoint, str]:
    keys = ("temperature_c", "exposure_s", "gain", "channel")
    return OperatingPoint(*(row[k] for k in keys)), row["plane"]


def _looks(p: Palette) -> str:
    return f"""
:host {{ overflow:hidden auto; max-height:{TALL}; }}
.pair {{ display:grid; grid-template-columns:minmax(284px, 2fr) minmax(0, 5fr); gap:10px;
  align-content:start; }}
button {{ font:inherit; color:inherit; border:0; background:none; cursor:pointer; padding:0; }}
button:focus-visible {{ outline:2px solid {p.present}; outline-offset:1px; }}
.families {{ display:flex; flex-direction:column; gap:1px; align-self:start; }}
.family {{ display:grid; grid-template-columns:152px minmax(30px, 1fr) 34px; gap:6px;
  align-items:center; text-align:left; padding:2px 4px; border-radius:4px; min-height:20px; }}
.family:hover {{ background:{p.background}; }}
.family.chosen {{ background:{p.background}; box-shadow:inset 3px 0 0 {p.present}; }}
.family .number {{ text-align:right; font-variant-numeric:tabular-nums; }}
.bar {{ position:relative; height:12px; background:{p.background}; border-radius:2px; }}
.fill {{ position:absolute; inset:0 auto 0 0; background:{p.present}; border-radius:2px; }}
.fill.good {{ background:{p.good}; }}
.one {{ position:absolute; top:-2px; bottom:-2px; width:0; border-left:1px dashed {p.quiet}; }}
.mark {{ position:absolute; top:-2px; bottom:-2px; width:3px; background:{p.wang}; }}
.mark[hidden] {{ display:none; }}
.matrix {{ min-width:0; align-self:start; }}
.list {{ overflow:auto; position:relative; }}
.cut {{ opacity:0; }}
.list thead th {{ position:sticky; top:0; z-index:2; background:{p.card}; }}
.more {{ display:block; width:100%; height:15px; font-size:11px; line-height:13px;
  color:{p.present}; background:{p.background}; border-radius:2px; }}
.more[hidden] {{ display:none; }}
table {{ border-collapse:separate; border-spacing:1px; width:100%; }}
th {{ font-weight:400; font-size:11px; text-align:left; line-height:1.2; padding:1px 4px 1px 0; }}
thead th {{ text-align:center; color:{p.quiet}; vertical-align:bottom; }}
thead th:first-child {{ text-align:left; }}
.steep thead th:not(:first-child) span {{ writing-mode:vertical-rl; transform:rotate(180deg); }}
thead th span {{ white-space:nowrap; }}
td {{ padding:0; min-width:22px; height:20px; }}
.cell {{ width:100%; height:100%; min-height:20px; text-align:center; font-size:11px;
  border-radius:2px; font-variant-numeric:tabular-nums; }}
@container (min-width:1200px) {{ table {{ width:auto; }} td {{ width:76px; }} }}
.cell.chosen {{ box-shadow:0 0 0 2px {p.ink}; position:relative; z-index:1; }}
{LOW}
{LARGE}
"""
