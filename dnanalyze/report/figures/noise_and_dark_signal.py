"""Dark signal and noise over temperature, the Arrhenius plot among them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.analyzers.estimators.arrhenius import unusual
from dnanalyze.report.figures.over_operating_points import draw_statistic, one_line_each, tells
from dnanalyze.report.figures.style import (
    ACCENT,
    Cell,
    Layer,
    Picture,
    log_axis,
    main_run,
    panels,
)
from dnanalyze.report.words import is_number, with_error
from dnanalyze.thermal import KELVIN, activation

NOISES = {"temporal_noise": "temporal dark noise", "pattern_noise": "mean frame"}


def over_temperature(drawn: Sequence[Layer]) -> Picture | None:
    """Arrhenius plot of the dark signal above the black level, and the two noises."""
    measured = drawn[0].statistics
    warm = _warm(drawn[0])
    known = pedestal_of(drawn[0]) is not None

    def first(ax: Any) -> None:
        if known:
            draw_arrhenius(ax, drawn)
            ax.set_title("dark signal", pad=18)

    def noise(name: str, title: str) -> Cell:
        return Cell(lambda ax: draw_statistic(ax, drawn, name).set_title(title), 3.35, 2.7)

    cells = [Cell(first, 3.35, 2.7)]
    if not known and tells(drawn, "median"):
        cells.append(noise("median", "median dark signal"))
    cells += [noise(name, title) for name, title in NOISES.items() if tells(drawn, name)]
    left = (
        "Left: median dark signal above the black level over the inverse temperature; a thermally "
        "activated dark current makes a straight line."
        if known and len(warm) > 1
        else ""
    )
    return panels(
        cells,
        f"{left} Temporal dark noise, and standard deviation of the mean frame, over the "
        "operating points." + one_line_each(measured),
        "Arrhenius plot of the dark signal; temporal dark noise and standard deviation of the "
        "mean frame.",
    )


def _warm(layer: Layer) -> list[Any]:
    """The operating points of an Arrhenius plot: two temperatures or more, the rest the same."""
    run = main_run(
        layer.statistics, lambda s: s.point.temperature_c is not None and "median" in s.values
    )
    return run if len({s.point.temperature_c for s in run}) > 1 else []


def pedestal_of(layer: Layer) -> float | None:
    """The pedestal, DN: from the trends, else from the sensor, else unknown."""
    found = layer.statistics.trends.get("pedestal")
    if found is not None and is_number(found.value):
        return float(found.value)
    if layer.statistics.sensor.black_level is not None:
        return float(layer.statistics.sensor.black_level)
    return None


def draw_arrhenius(ax: Any, drawn: Sequence[Layer]) -> Any:
    """Median dark signal above the black level over 1000 / T, with the measured law."""
    warm, pedestal = _warm(drawn[0]), pedestal_of(drawn[0])
    if not warm or pedestal is None:
        return ax
    inverse = np.array([1000 / (s.point.temperature_c + KELVIN) for s in warm])
    for layer in drawn:
        own = [layer.like(s) for s in warm]
        y = np.array([s.values["median"].value - pedestal if s else math.nan for s in own], float)
        y[y <= 0] = math.nan
        if np.isfinite(y).any():
            look = layer.line | ({"linestyle": ""} if layer is drawn[0] else {})
            size = 5.0 if layer.band else 2.8
            ax.plot(inverse, y, marker="o", markersize=size, **look)
    if not ax.lines:
        return ax
    _law(ax, drawn[0], warm, pedestal)
    ax.set_yscale("log")
    log_axis(ax.yaxis)
    ax.set_xlabel("1000 / T [1/K]")
    ax.set_ylabel("median − black level [DN]")
    above = ax.secondary_xaxis(
        "top",
        functions=(lambda v: 1000 / np.maximum(v, 0.1) - KELVIN, lambda c: 1000 / (c + KELVIN)),
    )
    ticks = sorted({s.point.temperature_c for s in warm})
    ticks = ticks if len(ticks) <= 5 else ticks[:: math.ceil(len(ticks) / 4)]
    above.set_xticks(ticks, [f"{t:.3g} °C".replace("-", "−") for t in ticks])
    above.tick_params(labelsize=7, length=2)
    above.spines["top"].set_visible(False)
    return ax


def _law(ax: Any, layer: Layer, warm: Sequence[Any], pedestal: float) -> None:
    """The measured Arrhenius line, its activation energy in the legend."""
    trend = layer.statistics.trends.get("activation_energy_ev")
    if trend is None or not is_number(trend.value):
        return
    seen = [(s.point.temperature_c + KELVIN, s.values["median"].value - pedestal) for s in warm]
    seen = [(t, y) for t, y in seen if y > 0]
    if not seen:
        return
    hottest = max(seen)
    kelvin = np.linspace(min(t for t, _ in seen), hottest[0], 50)
    line = hottest[1] * np.exp(trend.value * activation(kelvin, hottest[0]))
    doubt = " (not typical of dark current)" if unusual(trend.value, trend.se) else ""
    ax.plot(1000 / kelvin, line, color=ACCENT, linewidth=1.0, linestyle=(0, (1, 2)),
            label=f"activation energy of the median {with_error(trend.value, trend.se)} eV"
            f"{doubt}")  # fmt: skip
