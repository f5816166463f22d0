"""Single statistics over the operating points, measured with its floor against the others."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import Scale, Value
from dnanalyze.report.figures.style import (
    INK,
    Layer,
    Picture,
    axis_of,
    figure,
    log_axis,
    name_layers,
    one_plane,
    picture,
    runs,
)
from dnanalyze.report.tables import info


def panels(drawn: Sequence[Layer], names: Sequence[str], caption: str) -> Picture | None:
    """One small panel a statistic, over temperature (else exposure, else the settings in order).

    Statistics that no setting has are left out.
    """
    measured = drawn[0].statistics
    own = one_plane(measured)
    wanted = [n for n in dict.fromkeys(names) if any(_finite(s.values.get(n)) for s in own)]
    if not wanted or len(own) < 2:
        return None
    _, axis, label = axis_of(own)
    columns = min(4, len(wanted))
    rows = math.ceil(len(wanted) / columns)

    def draw() -> Any:
        fig, axes = figure(rows, columns, 0.4 + 1.95 * rows)
        for ax, name in zip(axes.flat, wanted, strict=False):
            _panel(ax, name, own, axis, drawn)
        for ax in list(axes.flat)[len(wanted) :]:
            ax.set_axis_off()
        for place in range(len(wanted)):
            if place + columns >= len(wanted):
                axes.flat[place].set_xlabel(label)
        name_layers(fig, drawn)
        return fig

    bars = " Bars: two standard errors of the measured value as one of this type of sensor."
    if len(runs(own)) > 1:
        bars += " Operating points that differ in more than this axis are not joined."
    return picture(
        draw,
        caption + bars + _plane(measured),
        "Over the operating points: " + ", ".join(wanted),
    )


def _plane(statistics: Any) -> str:
    plane = statistics.settings[0].plane
    return f" Colour plane {plane}." if plane else ""


def _finite(value: Value | None) -> bool:
    return value is not None and math.isfinite(value.value)


def _panel(
    ax: Any, name: str, settings: Sequence[Any], x: np.ndarray, drawn: Sequence[Layer]
) -> None:
    about = info(name)
    plain: list[float] = []
    for layer in drawn:
        values = [getattr(layer.like(s), "values", {}).get(name) for s in settings]
        y = np.array([v.value if v is not None else math.nan for v in values], float)
        plain += [float(v) for v in y if math.isfinite(v)]
        marks = {"color": layer.colour, "linestyle": layer.dash, "linewidth": layer.width}
        for run in runs(settings):
            seen = [n for n in run if math.isfinite(y[n])]
            ax.plot(x[seen], y[seen], marker="o", markersize=3.2, **marks)
        if layer.band:
            ends = np.array(
                [ends_of(v, about.scale) if _finite(v) else (math.nan,) * 2 for v in values]
            )
            ax.vlines(x, ends[:, 0], ends[:, 1], color=INK, alpha=0.35, linewidth=3.2)
    if about.scale is Scale.LOG and plain and min(plain) > 0 and max(plain) / min(plain) > 3:
        ax.set_yscale("log")
        log_axis(ax.yaxis)
    unit = f" [{about.unit.replace('^2', '²')}]" if about.unit not in ("", "1") else ""
    ax.set_title(_title((about.title or name) + unit), fontsize=7.4, fontweight="normal")
    ax.margins(x=0.08, y=0.15)


def _title(text: str) -> str:
    """On two lines at most."""
    return "\n".join(textwrap.wrap(text, 40, max_lines=2, placeholder=" …"))


def ends_of(value: Any, scale: Scale, reach: float = 2.0) -> tuple[float, float]:
    """The value less and plus ``reach`` standard errors, taken on the statistic's own scale."""
    v, e = value.value, reach * value.se
    if not math.isfinite(e):
        return v, v
    if scale is Scale.LOG:
        return v * math.exp(-min(e, 50)), v * math.exp(min(e, 50))
    if scale is Scale.ROOT:
        root = 2 * math.sqrt(max(v, 0) + 0.375)
        return max(0.0, (max(root - e, 0) / 2) ** 2 - 0.375), ((root + e) / 2) ** 2 - 0.375
    return v - e, v + e
