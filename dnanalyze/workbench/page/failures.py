"""Where the model fails: families, statistics by operating point, and the figure of one."""

from __future__ import annotations

import html
from typing import Any

import numpy as np
import panel as pn
from bokeh.models import ColumnDataSource, FixedTicker, Range1d, TapTool, Whisker

from dnanalyze.analyzers.catalogue import catalogue as infos
from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.report.words import family_title
from dnanalyze.workbench import curves
from dnanalyze.workbench.curves import Address
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.style import card, hover, inner, plain_figure

MOST_ROWS = 14  # statistics of a family in the matrix, the worst first
LEAST, MOST = 0.1, 1000.0  # ends of the axis of errors
STEPS = (1.0, 2.0, 4.0, 10.0, 30.0)  # |difference| in sigma at which the colour changes


class Failures:
    """The pane."""

    def __init__(self, context: Context) -> None:
        self.context = context
        p = context.palette
        self._names: list[str] = []
        self._bars = ColumnDataSource({"y": [], "error": [], "wang": [], "name": [], "colour": []})
        self._cells = ColumnDataSource(
            {
                k: []
                for k in (
                    "x",
                    "y",
                    "colour",
                    "ink",
                    "z",
                    "measured",
                    "model",
                    "unit",
                    "row",
                    "where",
                )
            }
        )
        self._addresses: list[Address] = []
        self.bars = self._make_bars()
        self.matrix = self._make_matrix()
        self.figure = CurveFigure(context)
        style = [inner(p)]
        self.title = pn.pane.HTML("<h2>Where it fails</h2>", stylesheets=style, margin=0)
        self.view = pn.Column(
            self.title,
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
        )
        context.listeners.append(self.update)

    def _make_bars(self) -> Any:
        p = self.context.palette
        made = plain_figure(
            p,
            width=245,
            height=236,
            x_axis_type="log",
            x_range=(LEAST, MOST),
            y_range=Range1d(-0.6, 9.6),
            x_axis_label="model error (1 = second sensor)",
            tools="tap",
        )
        bars = made.hbar(
            y="y", right="error", left=LEAST, height=0.62, color="colour", source=self._bars,
            nonselection_alpha=0.55,
        )  # fmt: skip
        made.scatter(x="wang", y="y", marker="dash", angle=np.pi / 2, size=17, color=p.wang,
                     line_width=3, source=self._bars)  # fmt: skip
        made.ray(x=[1.0], y=[-1], angle=np.pi / 2, length=0, color=p.quiet, line_dash="4 3")
        made.add_tools(
            hover(p, [bars], ("family", "@name"), ("model error", "@error{0.00}"),
                  ("Wang 2025 model", "@wang{0.00}"))
        )  # fmt: skip
        made.select_one(TapTool).renderers = [bars]
        self._bars.selected.on_change("indices", self._family_chosen)
        return made

    def _make_matrix(self) -> Any:
        p = self.context.palette
        made = plain_figure(
            p, height=236, sizing_mode="stretch_width", x_range=Range1d(-0.5, 4.5),
            y_range=Range1d(-0.5, 3.5), tools="tap",
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
        self._cells.selected.on_change("indices", self._cell_chosen)
        return made

    def _family_chosen(self, attr: str, old: Any, new: list[int]) -> None:
        if new:
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
        if what in ("evaluation", "preview"):
            self._draw_bars()
        if what == "evaluation":
            self._draw_matrix()

    def _draw_bars(self) -> None:
        shown, baseline = self.context.shown, self.context.session.baseline
        if shown is None:
            return
        p = self.context.palette
        families = sorted(shown.families, key=lambda name: shown.families[name])
        if families != self._names and not shown.preview:
            self._names = families
        names = self._names or families
        errors = [shown.families.get(n, np.nan) for n in names]
        wang = [baseline.families.get(n, np.nan) if baseline else np.nan for n in names]
        self._bars.data = {
            "y": list(range(len(names))),
            "error": [float(np.clip(e, LEAST, MOST)) for e in errors],
            "wang": [float(np.clip(w, LEAST, MOST)) for w in wang],
            "name": [family_title(n) for n in names],
            "colour": [p.present if e > 1.3 else p.good for e in errors],
        }
        self.bars.y_range.start, self.bars.y_range.end = -0.6, len(names) - 0.4
        self.bars.yaxis.ticker = FixedTicker(ticks=list(range(len(names))))
        self.bars.yaxis.major_label_overrides = {
            i: family_title(n).split(" and ")[0].split(",")[0] for i, n in enumerate(names)
        }

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
            data["measured"].append(f"{r['measured']:.4g}")
            data["model"].append(f"{r['simulated']:.4g}")
            data["unit"].append("" if r["unit"] == "1" else r["unit"])
            data["row"].append(known[r["name"]].title)
            data["where"].append(_label(*_place(r)))
            addresses.append(Address(r["name"], *_place(r)))
        self._addresses = addresses
        self._cells.selected.indices = []
        self._cells.data = data
        self._axes(names, points)
        if context.address is None and addresses:
            sizes = [abs(float(r["discrepancy"])) for r in rows if r["name"] in names]
            context.address = addresses[int(np.argmax(sizes))]
            context.tell("address")

    def _axes(self, names: list[str], points: list[tuple[OperatingPoint, str]]) -> None:
        made, known = self.matrix, infos()
        made.x_range.start, made.x_range.end = -0.5, len(points) - 0.5
        made.y_range.start, made.y_range.end = -0.5, len(names) - 0.5
        made.xaxis.ticker = FixedTicker(ticks=list(range(len(points))))
        labels = _short([_label(*p) for p in points])
        made.xaxis.major_label_overrides = dict(enumerate(labels))
        made.xaxis.major_label_orientation = 0.0 if len(points) <= 6 else 0.7
        made.yaxis.ticker = FixedTicker(ticks=list(range(len(names))))
        made.yaxis.major_label_overrides = {
            len(names) - 1 - i: _cut(known[n].title) for i, n in enumerate(names)
        }


class CurveFigure:
    """A statistic's figure: measured with its error band, and the models."""

    LAYERS = ("measured", "Wang 2025 model", "present model", "candidate")

    def __init__(self, context: Context) -> None:
        self.context = context
        p = context.palette
        style = [inner(p)]
        self.title = pn.pane.HTML(
            "", stylesheets=style, margin=(4, 0, 0, 0), sizing_mode="stretch_width"
        )
        self.what = pn.widgets.RadioButtonGroup(
            options=["curve", "all points"], value="curve", stylesheets=style,
            margin=0, width=130,
        )  # fmt: skip
        self.csv = pn.widgets.FileDownload(
            callback=self._csv, filename="figure.csv", label="CSV", button_type="default",
            stylesheets=style, margin=0, width=48,
        )  # fmt: skip
        self.png = pn.widgets.FileDownload(
            callback=lambda: self._drawn("png"), filename="figure.png", label="PNG",
            button_type="default", stylesheets=style, margin=0, width=48,
        )  # fmt: skip
        self.svg = pn.widgets.FileDownload(
            callback=lambda: self._drawn("svg"), filename="figure.svg", label="SVG",
            button_type="default", stylesheets=style, margin=0, width=48,
        )  # fmt: skip
        self.what.param.watch(lambda _: self._draw(), "value")
        self._sources = {
            name: ColumnDataSource({"x": [], "y": [], "low": [], "high": []})
            for name in self.LAYERS
        }
        self._kind: tuple[Any, ...] = ()
        self.pane = pn.pane.Bokeh(sizing_mode="stretch_both", margin=0, min_height=150)
        self.view = pn.Column(
            self.title,
            pn.Row(
                self.what, pn.layout.HSpacer(), self.csv, self.png, self.svg,
                margin=0, sizing_mode="stretch_width",
            ),
            self.pane,
            sizing_mode="stretch_both",
            margin=0,
        )  # fmt: skip
        context.listeners.append(self.update)

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what in ("address", "evaluation", "preview", "candidate"):
            self._draw()

    def _statistics(self) -> dict[str, Any]:
        context, session = self.context, self.context.session
        assert session.bench is not None
        shown = context.shown
        return {
            "measured": session.bench.measured[1],
            "Wang 2025 model": session.baseline.simulated if session.baseline else None,
            "present model": shown.simulated if shown else None,
            "candidate": context.candidate[1] if context.candidate else None,
        }

    def _curves(self) -> tuple[curves.Axes, list[str], dict[str, curves.Curve]]:
        """Axes, labels of the abscissa (none for a continuous one), curves by layer."""
        address = self.context.address
        assert address is not None
        layers = {k: v for k, v in self._statistics().items() if v is not None}
        axes = curves.axes(address)
        if axes is not None and self.what.value == "curve":
            measured = layers["measured"]
            found = {k: curves.curve(v, address, measured) for k, v in layers.items()}
            if found["measured"] is not None:
                return axes, [], {k: v for k, v in found.items() if v is not None}
        info = infos()[address.name]
        unit = f"value [{info.unit}]" if info.unit not in ("", "1") else "value"
        labels, _ = curves.over_points(layers["measured"], address)
        made = {k: curves.over_points(v, address)[1] for k, v in layers.items()}
        made = {k: c for k, c in made.items() if len(c.y) == len(labels)}
        ends = np.concatenate([c.y for c in made.values()]) if made else np.ones(1)
        log = bool(np.all(ends > 0) and ends.max() > 20 * ends.min())
        return curves.Axes("operating point", unit, False, log), labels, made

    def _draw(self) -> None:
        session, address = self.context.session, self.context.address
        if session.bench is None or address is None:
            return
        axes, labels, found = self._curves()
        where = _label(address.point, address.plane)
        self.title.object = (
            "<div style='white-space:nowrap;overflow:hidden;text-overflow:ellipsis'>"
            f"<b>{infos()[address.name].title}</b> "
            f"<span class=quiet>{html.escape(where)}</span></div>"
        )
        kind = axes, tuple(labels)
        if kind != self._kind:
            self._kind = kind
            self.pane.object = self._make(axes, labels)
        for name, source in self._sources.items():
            c = found.get(name)
            source.data = (
                {"x": [], "y": [], "low": [], "high": []}
                if c is None
                else {"x": c.x, "y": c.y, "low": c.low, "high": c.high}
            )

    def _make(self, axes: curves.Axes, labels: list[str]) -> Any:
        p = self.context.palette
        made = plain_figure(
            p, sizing_mode="stretch_both", x_axis_label=axes.x, y_axis_label=axes.y,
            x_axis_type="log" if axes.log_x else "linear",
            y_axis_type="log" if axes.log_y else "linear", tools="pan,wheel_zoom,box_zoom,reset",
        )  # fmt: skip
        looks = {
            "measured": (p.ink, "solid", 1.6),
            "Wang 2025 model": (p.wang, "8 3", 1.8),
            "present model": (p.present, "solid", 2.2),
            "candidate": (p.candidate, "2 2", 2.4),
        }
        drawn = []
        if labels:
            made.xaxis.ticker = FixedTicker(ticks=list(range(len(labels))))
            made.xaxis.major_label_overrides = dict(enumerate(_short(labels)))
            made.add_layout(
                Whisker(source=self._sources["measured"], base="x", upper="high", lower="low",
                        line_color=p.ink)
            )  # fmt: skip
        else:
            made.varea(x="x", y1="low", y2="high", source=self._sources["measured"],
                       fill_color=p.ink, fill_alpha=0.16)  # fmt: skip
        for name, (colour, dash, width) in looks.items():
            drawn.append(
                made.line("x", "y", source=self._sources[name], color=colour, line_dash=dash,
                          line_width=width, legend_label=name, name=name)
            )  # fmt: skip
            if labels:
                made.scatter("x", "y", source=self._sources[name], color=colour, size=6)
        made.add_tools(
            hover(p, drawn, ("", "$name"), (axes.x.split(" [")[0], "@x{0.0000}"),
                  (axes.y.split(" [")[0], "@y{0.000e}" if axes.log_y else "@y{0.000}"),
                  mode="mouse")
        )  # fmt: skip
        legend = made.legend[0]
        legend.label_text_font_size = "10px"
        legend.label_text_color = p.ink
        legend.background_fill_color = p.card
        legend.background_fill_alpha = 0.75
        legend.border_line_color = None
        legend.padding = legend.margin = 3
        legend.spacing = 0
        legend.orientation = "horizontal"
        made.add_layout(legend, "above")
        return made

    def _csv(self) -> Any:
        import io

        import pandas as pd

        axes, labels, found = self._curves()
        tables = []
        for name, c in found.items():
            table = pd.DataFrame({"layer": name, axes.x: labels or c.x, axes.y: c.y})
            tables.append(table.assign(low=c.low, high=c.high))
        return io.BytesIO(pd.concat(tables).to_csv(index=False).encode())

    def _drawn(self, form: str) -> Any:
        import io

        from matplotlib.figure import Figure

        axes, labels, found = self._curves()
        fig = Figure(figsize=(7, 4.2), layout="constrained")
        ax = fig.add_subplot()
        looks = {"measured": ("#16191d", "-"), "Wang 2025 model": ("#b86e00", "--"),
                 "present model": ("#0072b2", "-"), "candidate": ("#b5348f", ":")}  # fmt: skip
        for name, c in found.items():
            colour, dash = looks[name]
            ax.plot(c.x, c.y, dash, color=colour, label=name, marker="o" if labels else None)
            if name == "measured":
                ax.fill_between(c.x, c.low, c.high, color=colour, alpha=0.15, linewidth=0)
        ax.set(xlabel=axes.x, ylabel=axes.y)
        ax.set_xscale("log" if axes.log_x else "linear")
        ax.set_yscale("log" if axes.log_y else "linear")
        if labels:
            ax.set_xticks(range(len(labels)), _short(labels))
        ax.legend(frameon=False)
        out = io.BytesIO()
        fig.savefig(out, format=form, dpi=150)
        out.seek(0)
        return out


def _place(row: Any) -> tuple[OperatingPoint, str]:
    keys = ("temperature_c", "exposure_s", "gain", "channel")
    return OperatingPoint(*(row[k] for k in keys)), row["plane"]


def _label(point: OperatingPoint, plane: str) -> str:
    return f"{point.label().replace(' C', ' °C')} {plane}".strip()


def _short(labels: list[str]) -> list[str]:
    """Labels without what all of them share."""
    parts = [label.split(", ") for label in labels]
    shared = set.intersection(*(set(p) for p in parts)) if len(parts) > 1 else set()
    return [", ".join(x for x in p if x not in shared) or label
            for p, label in zip(parts, labels, strict=True)]  # fmt: skip


def _cut(title: str) -> str:
    return title if len(title) <= 34 else title[:33] + "…"
