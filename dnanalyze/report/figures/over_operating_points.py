"""Single statistics over the operating points, measured with its uncertainty beside the others."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import Any, TypeGuard

import numpy as np

from dnanalyze.analyzers.statistics import Scale, Statistics, Value
from dnanalyze.report.figures.style import (
    INK,
    ORDER,
    Cell,
    Layer,
    Picture,
    axis_of,
    log_axis,
    one_plane,
    panels,
    quantity,
    runs,
)
from dnanalyze.report.statistic_rows import info
from dnanalyze.report.words import varied

BAND = 2.0  # standard errors that the line through a measured value reaches
WIDE = 100.0  # ratio of the ends of an exposure axis from which it is logarithmic


def draw_statistic(ax: Any, drawn: Sequence[Layer], name: str) -> Any:
    """One statistic over temperature (else exposure, gain, else the settings in order).

    Parameters
    ----------
    ax : matplotlib axes
    drawn : sequence of Layer
        The measured first.
    name : str
        Of the statistic.
    """
    settings = [s for s in one_plane(drawn[0].statistics) if _finite(s.values.get(name))]
    if not settings:
        return ax
    _, x, label = axis_of(settings)
    about = info(name)
    plain: list[float] = []
    for layer in drawn:
        values = [getattr(layer.like(s), "values", {}).get(name) for s in settings]
        y = np.array([v.value if v is not None else math.nan for v in values], float)
        plain += [float(v) for v in y if math.isfinite(v)]
        look = layer.line
        for run in runs(settings):
            seen = [n for n in run if math.isfinite(y[n])]
            if seen:
                size = 5.0 if layer.band else 2.8  # so that each shows where they coincide
                ax.plot(x[seen], y[seen], marker="o", markersize=size, **look)
        if layer.band:
            ends = np.array(
                [
                    about.scale.ends(v.value, v.se, BAND) if _finite(v) else (math.nan, math.nan)
                    for v in values
                ]
            )
            ax.vlines(x, ends[:, 0], ends[:, 1], color=INK, alpha=0.35, linewidth=3.2)
    if about.scale is Scale.LOG and plain and min(plain) > 0 and max(plain) / min(plain) > 3:
        ax.set_yscale("log")
        log_axis(ax.yaxis)
    if label.startswith("exposure") and x.min() > 0 and x.max() > WIDE * x.min():
        ax.set_xscale("log")
        log_axis(ax.xaxis)
    if label == ORDER:
        ax.xaxis.get_major_locator().set_params(integer=True)
    ax.margins(x=0.08, y=0.15)
    ax.set_xlabel(label)
    ax.set_ylabel(_title(quantity(about.title or name, about.unit)))
    return ax


def statistics(
    drawn: Sequence[Layer], names: Sequence[str], caption: str, most: int = 8
) -> Picture | None:
    """A small panel a statistic; those that say nothing here are left out."""
    measured = drawn[0].statistics
    wanted = [n for n in dict.fromkeys(names) if tells(drawn, n)][:most]
    if not wanted:
        return None

    def cell(name: str) -> Cell:
        return Cell(lambda ax: draw_statistic(ax, drawn, name), 2.52, 2.0)

    bars = " Bars: two standard errors of the measured value for this type of sensor."
    return panels(
        [cell(n) for n in wanted],
        caption + bars + one_line_each(measured),
        "Over the operating points: " + ", ".join(info(n).title for n in wanted),
    )


NAMES = {"temperature_c": "temperature", "exposure_s": "exposure", "gain": "gain"}


def one_line_each(measured: Statistics) -> str:
    """What a line stands for where the operating points differ in more than the axis."""
    own = one_plane(measured)
    key = axis_of(own)[0]
    apart = [NAMES.get(k, k) for k in varied(vars(s.point) for s in own) if k != key]
    note = f" One line per {' and '.join(sorted(apart))}." if key and apart else ""
    return note + (f" Colour plane {own[0].plane}." if own[0].plane else "")


def tells(drawn: Sequence[Layer], name: str) -> bool:
    """Two operating points have it, and it is not the same everywhere, such as a count of 0."""
    own = one_plane(drawn[0].statistics)
    if sum(_finite(s.values.get(name)) for s in own) < 2:
        return False
    alike = [k.like(s) for k in drawn if k.label != "Gaussian" for s in own]
    found = [s.values[name].value for s in alike if s is not None and name in s.values]
    return len({v for v in found if math.isfinite(v)}) > 1


def _finite(value: Value | None) -> TypeGuard[Value]:
    return value is not None and math.isfinite(value.value)


def _title(text: str) -> str:
    """On two lines at most."""
    return "\n".join(textwrap.wrap(text, 30, max_lines=2, placeholder=" …"))
