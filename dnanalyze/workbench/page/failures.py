"""Where the model fails: families, statistics by operating point, and the figure of one."""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
import panel as pn
from bokeh.models import ColumnDataSource, FixedTicker, Range1d, TapTool
from matplotlib.figure import Figure

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.digits import number, symbol
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.report.figures.heatmap import draw_families, draw_heatmap
from dnanalyze.report.words import family_title
from dnanalyze.workbench.curves import Address
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.downloads import downloads
from dnanalyze.workbench.page.figure import CurveFigure
from dnanalyze.workbench.page.points import labelled, without_shared
from dnanalyze.workbench.page.style import card, hover, inner, plain_figure

MOST_LETTERS = 37  # of a row's label
SHORTER = (  # words of a label that is too long
    ("temporal noise", "temporal"), (", over its mean", ""), (" c/px", ""),
    (" of whole ", " whole "), (" along the ", " along "),
    ("at the lowest three frequencies", "lowest"),
)  # fmt: skip
MOST_ROWS = 12  # statistics of a family in the matrix, the worst first
LEAST, MOST = 0.1, 1000.0  # ends of the axis of errors
STEPS = (1.0, 2.0, 4.0, 10.0, 30.0)  # |difference| in sigma at which the colour changes
BAR = ("y", "error", "mark", "name", "colour", "marked")
CELL = ("x", "y", "colour", "ink", "z", "measured", "model", "unit", "row", "where")


class Failures:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        p = context.palette
        self._names: list[str] = []
        self._bars = ColumnDataSource({k: [] for k in BAR})
        self._cells = ColumnDataSource({k: [] for k in CELL})
        self._addresses: list[Address] = []
        self.bars = self._make_bars()
        self.matrix = self._make_matrix()
        self.figure = CurveFigure(context)
        style = [inner(p)]
        self.title = pn.pane.HTML("<h2>Where it fails</h2>", stylesheets=style, margin=0)
        self.view = pn.Column(
            pn.Row(
                self.title, pn.layout.HSpacer(),
                *downloads(
                    "model_error", self._table, self._picture, style,
                    "families and statistics",
                ),
                margin=0, sizing_mode="stretch_width",
            ),
            pn.Row(
                pn.pane.Bokeh(self.bars, margin=0),
                pn.pane.Bokeh(self.matrix, margin=0),
                margin=0,
                sizing_mode="stretch_width",
            ),
            self.figure.view,
            styles=card(p),
            sizing_mode="stretch_both",
            margin=0,
        )  # fmt: skip
        context.listeners.append(self.update)

    def _make_bars(self) -> Any:
        p = self.context.palette
        made = plain_figure(
            p,
            width=232,
            min_border_right=10,
            height=236,
            x_axis_type="log",
            x_range=(LEAST, MOST),
            y_range=Range1d(-0.6, 9.6),
            x_axis_label="model error",
            css_classes=["families"],
            tools="tap",
        )
        bars = made.hbar(
            y="y", right="error", left=LEAST, height=0.62, color="colour", source=self._bars,
            nonselection_alpha=0.55,
        )  # fmt: skip
        made.scatter(x="mark", y="y", marker="dash", angle=np.pi / 2, size=17, color=p.wang,
                     line_width=3, nonselection_alpha=1.0, source=self._bars)  # fmt: skip
        made.ray(x=[1.0], y=[-1], angle=np.pi / 2, length=0, color=p.quiet, line_dash="4 3")
        made.add_tools(
            hover(p, [bars], ("family", "@name"), ("model error", "@error{0.00}"),
                  ("@marked", "@mark{0.00}"))
        )  # fmt: skip
        made.select_one(TapTool).renderers = [bars]
        made.yaxis.ticker = FixedTicker(ticks=[])
        self._bars.selected.on_change("indices", self._family_chosen)
        return made

    def _make_matrix(self) -> Any:
        p = self.context.palette
        made = plain_figure(
            p, height=236, sizing_mode="stretch_width", x_range=Range1d(-0.5, 4.5),
            y_range=Range1d(-0.5, 3.5), tools="tap", css_classes=["matrix"],
            x_axis_label="(measured − model) / σ",
        )  # fmt: skip
        cells = made.rect(
            x="x", y="y", width=0.96, height=0.92, fill_color="colour", line_color=p.card,
            nonselection_alpha=0.75, source=self._cells,
        )  # fmt: skip
        made.text(
            x="x", y="y", text="z", text_align="center", text_baseline="middle",
            text_font_size="10px", text_color="ink", source=self._cells,
        )  # fmt: skip
        made.grid.grid_line_color = None
        made.add_tools(
            hover(p, [cells], ("statistic", "@row"), ("operating point", "@where"),
                  ("measured", "@measured @unit"), ("model", "@model @unit"),
                  ("difference", "@z σ"))
        )  # fmt: skip
        made.select_one(TapTool).renderers = [cells]
        made.xaxis.ticker, made.yaxis.ticker = FixedTicker(ticks=[]), FixedTicker(ticks=[])
        self._cells.selected.on_change("indices", self._cell_chosen)
        return made

    def _family_chosen(self, attr: str, old: Any, new: list[int]) -> None:
        if new and self._names[new[0]] != self.context.family:
            self.context.family = self._names[new[0]]
            self.context.address = None
            self._draw_matrix()
            self.context.tell("address")

    def _cell_chosen(self, attr: str, old: Any, new: list[int]) -> None:
        if new:
            self.context.address = self._addresses[new[0]]
            self.context.tell("address")

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what in ("evaluation", "preview", "compared"):
            self._draw_bars()
        if what == "evaluation":
            self._draw_matrix()

    def _draw_bars(self) -> None:
        shown = self.context.shown
        if shown is None:
            return
        p = self.context.palette
        if not shown.preview or not self._names:
            self._names = sorted(shown.families, key=lambda name: shown.families[name])
        names = self._names
        if self.context.family in names:  # the bars are sorted anew
            self._bars.selected.indices = [names.index(self.context.family)]
        errors = [shown.families.get(n, np.nan) for n in names]
        marked, families = self._marked()
        marks = [families.get(n, np.nan) for n in names]
        self._bars.data = {
            "y": list(range(len(names))),
            "error": [float(np.clip(e, LEAST, MOST)) for e in errors],
            "mark": [float(np.clip(m, LEAST, MOST)) for m in marks],
            "marked": [marked] * len(names),
            "name": [family_title(n) for n in names],
            "colour": [p.present if e > 1.3 else p.good for e in errors],
        }
        self.title.object = (
            "<h2>Where it fails <span style='font-weight:400;font-size:11px' class=quiet>"
            f"<span style='color:{p.wang}'>▌</span>{html.escape(marked)}</span></h2>"
        )
        self.bars.y_range.start, self.bars.y_range.end = -0.6, len(names) - 0.4
        self.bars.yaxis.ticker.ticks = list(range(len(names)))
        self.bars.yaxis.major_label_overrides = {
            i: family_title(n).split(" and ")[0].split(",")[0] for i, n in enumerate(names)
        }

    def _marked(self) -> tuple[str, Mapping[str, float]]:
        """Name and families' errors of the model that the marks show."""
        node, wang = self.context.compared, self.context.session.baseline
        if node is not None:
            return node.title, node.families
        return "Wang 2025 model", wang.families if wang else {}

    def _draw_matrix(self) -> None:
        evaluation = self.context.session.evaluation
        if evaluation is None:
            return
        context, known = self.context, infos()
        if context.family not in evaluation.families:
            context.family = max(evaluation.families, key=lambda n: evaluation.families[n])
        rows = [r for r in evaluation.rows if r["family"] == context.family]
        worst: dict[str, float] = {}
        for r in rows:
            worst[r["name"]] = max(worst.get(r["name"], 0.0), abs(r["discrepancy"]))
        names = sorted(worst, key=lambda n: -worst[n])[:MOST_ROWS]
        points = list(dict.fromkeys(_place(r) for r in rows))
        data: dict[str, list[Any]] = {k: [] for k in self._cells.data}
        addresses = []
        for r in rows:
            if r["name"] not in names:
                continue
            z = float(r["discrepancy"])
            data["x"].append(points.index(_place(r)))
            data["y"].append(len(names) - 1 - names.index(r["name"]))
            data["colour"].append(context.palette.heat[int(np.searchsorted(STEPS, abs(z)))])
            data["ink"].append("#ffffff" if abs(z) > STEPS[-2] else context.palette.ink)
            data["z"].append(f"{z:.0f}" if abs(z) >= 10 else f"{z:.1f}")
            data["measured"].append(number(r["measured"], 4))
            data["model"].append(number(r["simulated"], 4))
            data["unit"].append(symbol(r["unit"]))
            data["row"].append(known[r["name"]].title)
            data["where"].append(labelled(*_place(r)))
            addresses.append(Address(r["name"], *_place(r)))
        self._addresses = addresses
        self._cells.selected.indices = []
        self._cells.data = data
        self._axes(names, points)
        if context.address is None and addresses:
            sizes = [abs(float(r["discrepancy"])) for r in rows if r["name"] in names]
            context.address = addresses[int(np.argmax(sizes))]
            context.tell("address")

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

    def _axes(self, names: list[str], points: list[tuple[OperatingPoint, str]]) -> None:
        made, known = self.matrix, infos()
        made.x_range.start, made.x_range.end = -0.5, len(points) - 0.5
        made.y_range.start, made.y_range.end = -0.5, len(names) - 0.5
        made.xaxis.ticker.ticks = list(range(len(points)))
        labels = without_shared([labelled(*p) for p in points])
        made.xaxis.major_label_overrides = dict(enumerate(labels))
        made.xaxis.major_label_orientation = 0.0 if len(points) <= 6 else 0.7
        made.yaxis.ticker.ticks = list(range(len(names)))
        titles = short([known[n].title for n in names])
        made.yaxis.major_label_overrides = {len(names) - 1 - i: t for i, t in enumerate(titles)}


def _place(row: Any) -> tuple[OperatingPoint, str]:
    keys = ("temperature_c", "exposure_s", "gain", "channel")
    return OperatingPoint(*(row[k] for k in keys)), row["plane"]


def short(titles: list[str]) -> list[str]:
    """Titles that fit beside the matrix, each cut where it still differs from the others.

    Examples
    --------
    >>> from dnanalyze.workbench.page.failures import short
    >>> short([f"power of the temporal noise along the rows at {b} c/px" for b in ("0.1", "0.3")])
    ['temporal along the rows at 0.1 c/px', 'temporal along the rows at 0.3 c/px']
    >>> short(["temporal variance, 0 to 50 % quantile of the mean frame"])
    ['temporal variance, 0 to 50 % quant …']
    """
    whole = [_shortened(title) for title in titles]
    ends = [[_cut(title, share) for share in (1.0, 0.5, 0.0)] for title in whole]
    every = [[e[way] for e in ends] for way in range(3)]
    return [next((e[way] for way in range(3) if every[way].count(e[way]) == 1), e[1]) for e in ends]


def _shortened(title: str) -> str:
    """A title in fewer words, as far as needed."""
    title = title.removeprefix("power of the ")
    for words, fewer in SHORTER:
        if len(title) > MOST_LETTERS:
            title = title.replace(words, fewer)
    return title


def _cut(title: str, share: float) -> str:
    """A title with so much of its letters from its beginning, the others from its end."""
    if len(title) <= MOST_LETTERS:
        return title
    head = round(share * (MOST_LETTERS - 3))
    tail = MOST_LETTERS - 3 - head
    return " … ".join((title[:head].rstrip(), title[len(title) - tail :].lstrip())).strip()
