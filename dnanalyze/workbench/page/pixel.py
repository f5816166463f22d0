"""The values of one pixel over frames and over operating points, measured and simulated."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pandas as pd
import panel as pn
from bokeh.models import BasicTicker, ColumnDataSource, FixedTicker
from matplotlib.figure import Figure

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.report.words import celsius
from dnanalyze.workbench.frames import View
from dnanalyze.workbench.page.background import Latest
from dnanalyze.workbench.page.context import Context
from dnanalyze.workbench.page.downloads import downloads
from dnanalyze.workbench.page.points import labelled, without_shared
from dnanalyze.workbench.page.style import hover, inner, plain_figure

ASIDE = 0.12  # of a place on the abscissa, between measured and simulated values


class Pixel:
    """Two figures: frames of the chosen operating point, and all operating points.

    Parameters
    ----------
    context : Context
    """

    def __init__(self, context: Context) -> None:
        self.context = context
        p = context.palette
        self._latest = Latest(context.back)
        self._values: dict[str, list[np.ndarray]] = {}
        self._setting = 0
        self._at: tuple[int, int] | None = None
        self._frames, self._points = _sources(), _sources()
        self.over_frames = self._figure(
            self._frames, sizing_mode="stretch_both", x_axis_label="frame"
        )
        self.over_frames.xaxis.ticker = BasicTicker(min_interval=1)
        self.over_points = self._figure(
            self._points, sizing_mode="stretch_both", x_axis_label="operating point",
            x_range=(-0.5, len(context.session.captures.settings) - 0.5),
        )  # fmt: skip
        settings = context.session.captures.settings
        every = max(1, -(-len(settings) // 6))
        self.over_points.xaxis.ticker = FixedTicker(ticks=list(range(0, len(settings), every)))
        self.over_points.xaxis.major_label_overrides = {
            i: str(i) if s.point.temperature_c is None else celsius(s.point.temperature_c)
            for i, s in enumerate(settings)
        }
        style = [inner(p)]
        self.title = pn.pane.HTML(
            "<span class=quiet>A click on a pixel shows its values.</span>",
            stylesheets=style, margin=(2, 0, 0, 0), css_classes=["pixel"],
            sizing_mode="stretch_width",
        )  # fmt: skip
        self.view = pn.Column(
            pn.Row(
                self.title,
                *downloads("pixel", self._table, self._picture, style, "values of the pixel"),
                margin=0, sizing_mode="stretch_width",
            ),
            pn.pane.Bokeh(self.over_points, margin=0, sizing_mode="stretch_both", min_height=90),
            pn.pane.Bokeh(self.over_frames, margin=0, sizing_mode="stretch_both", min_height=90),
            margin=0, sizing_mode="stretch_both", styles={"min-height": "0"},
        )  # fmt: skip
        context.listeners.append(self.update)

    def update(self, what: str) -> None:
        """Draw what has changed."""
        if what == "evaluation" and self._at is not None:
            self.show(*self._at, self._setting)

    def _figure(self, sources: dict[str, ColumnDataSource], **options: Any) -> Any:
        p = self.context.palette
        made = plain_figure(
            p, y_axis_label="pixel value [DN]", tools="wheel_zoom,pan,reset", **options
        )
        looks = {"measured": (p.ink, "circle"), "simulated": (p.present, "triangle")}
        drawn = [
            made.scatter("x", "y", source=sources[n], color=c, marker=m, size=5, alpha=0.8)
            for n, (c, m) in looks.items()
        ]
        made.add_tools(hover(p, drawn, ("value", "@y{0.0} DN"), ("operating point", "@where")))
        return made

    def show(self, row: int, column: int, setting: int) -> None:
        """Take the values of a pixel and draw them."""
        session, shown = self.context.session, self.context.shown
        model = None if shown is None else shown.model
        self._at, self._setting = (row, column), setting

        def work() -> Any:
            return session.pictures.pixel(row, column, model)

        def draw(found: Any) -> None:
            p = self.context.palette
            self.title.object = (
                f"<b>Pixel</b> column {column}, row {row} &nbsp;<span class=quiet>● measured "
                f"<span style='color:{p.present}'>▲ simulated</span></span>"
            )
            self._values = found
            self.draw()

        self._latest.ask(work, draw, lambda error: session.tell(str(error)))

    def chosen(self, view: View, point: OperatingPoint) -> None:
        """Draw the frames of another operating point."""
        self._setting = view.setting
        self.draw()

    def draw(self) -> None:
        """Draw the values that there are."""
        settings = self.context.session.captures.settings
        for name in self._frames:
            values = self._values.get(name, [])
            aside = ASIDE if name == "simulated" else -ASIDE
            data: dict[str, list[Any]] = {"x": [], "y": [], "where": []}
            for i, (v, s) in enumerate(zip(values, settings, strict=False)):
                data["x"] += list(i + aside + np.linspace(-0.1, 0.1, len(v)))
                data["y"] += list(v)
                data["where"] += [labelled(s.point)] * len(v)
            self._points[name].data = data
            here = values[self._setting] if self._setting < len(values) else np.zeros(0)
            self._frames[name].data = {
                "x": list(range(len(here))),
                "y": list(here),
                "where": [labelled(settings[self._setting].point)] * len(here),
            }

    def _table(self) -> pd.DataFrame:
        """One row a value; without a pixel the names of the columns."""
        settings = self.context.session.captures.settings
        row, column = self._at or (-1, -1)
        rows = [
            {"layer": name, "column": column, "row": row, **vars(s.point), "frame": k, "value": v}
            for name, values in self._values.items()
            for s, here in zip(settings, values, strict=False)
            for k, v in enumerate(here)
        ]
        point = [field.name for field in fields(OperatingPoint)]
        return pd.DataFrame(rows, columns=["layer", "column", "row", *point, "frame", "value"])

    def _picture(self) -> Figure:
        """Values over the operating points."""
        made = Figure(figsize=(7, 4), layout="constrained")
        ax = made.add_subplot()
        looks = {"measured": ("#16191d", "o"), "simulated": ("#0072b2", "^")}
        for name, source in self._points.items():
            colour, marker = looks[name]
            ax.plot(source.data["x"], source.data["y"], marker, color=colour, label=name, ms=4)
        settings = self.context.session.captures.settings
        ax.set_xticks(range(len(settings)), without_shared([labelled(s.point) for s in settings]))
        row, column = self._at or (-1, -1)
        ax.set(ylabel="pixel value [DN]", title=f"column {column}, row {row}")
        ax.legend(frameon=False)
        return made


def _sources() -> dict[str, ColumnDataSource]:
    return {
        name: ColumnDataSource({"x": [], "y": [], "where": []})
        for name in ("measured", "simulated")
    }
