"""Dark signal and noise over temperature, the Arrhenius plot among them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.analyzers.estimators.arrhenius import unusual
from dnanalyze.model.laws import BOLTZMANN_EV, KELVIN
from dnanalyze.report.figures.style import (
    ACCENT,
    MODEL,
    Layer,
    Picture,
    figure,
    log_axis,
    main_run,
    name_layers,
    picture,
    plane_note,
)
from dnanalyze.report.words import is_number, with_error

NOISES = (("temporal_noise", "temporal noise"), ("pattern_noise", "fixed-pattern noise"))


def over_temperature(drawn: Sequence[Layer]) -> Picture | None:
    """Arrhenius plot of the dark signal above the pedestal, and the two noises."""
    measured = drawn[0].statistics
    warm = [s for s in main_run(measured) if s.point.temperature_c is not None]
    if len({s.point.temperature_c for s in warm}) < 2 or "median" not in warm[0].values:
        return None

    def draw() -> Any:
        fig, axes = figure(1, 3, 2.9, gridspec_kw={"width_ratios": (1.25, 1, 1)})
        pedestal = pedestal_of(drawn[0])
        if pedestal is None:
            _noise(axes[0, 0], drawn, warm, "median", "median dark value, its pedestal unknown")
        else:
            _arrhenius(axes[0, 0], drawn, warm, pedestal)
        for ax, (name, title) in zip(axes[0, 1:], NOISES, strict=True):
            _noise(ax, drawn, warm, name, title)
        name_layers(fig, drawn)
        return fig

    return picture(
        draw,
        "Left: median dark signal above the pedestal over inverse temperature; a thermally "
        "activated current makes a straight line. Right: the two noises." + plane_note(measured),
        "Arrhenius plot of the dark signal, and temporal and fixed-pattern noise over temperature.",
    )


def pedestal_of(layer: Layer) -> float | None:
    """The pedestal, DN: from the trends, else from the sensor, else unknown."""
    found = layer.statistics.trends.get("pedestal")
    if found is not None and is_number(found.value):
        return float(found.value)
    if layer.statistics.sensor.black_level is not None:
        return float(layer.statistics.sensor.black_level)
    return None


def _arrhenius(ax: Any, drawn: Sequence[Layer], warm: Sequence[Any], pedestal: float) -> None:
    inverse = np.array([1000 / (s.point.temperature_c + KELVIN) for s in warm])
    for layer in drawn:
        own = [layer.like(s) for s in warm]
        y = np.array([s.values["median"].value - pedestal if s else math.nan for s in own], float)
        y[y <= 0] = math.nan
        ax.plot(
            inverse, y, marker="o", markersize=3.4, linestyle="-" if layer is not drawn[0] else "",
            color=layer.colour, linewidth=layer.width,
        )  # fmt: skip
    _law(ax, drawn[0], warm, pedestal)
    ax.set_yscale("log")
    log_axis(ax.yaxis)
    ax.set_xlabel("1000 / T [1/K]")
    ax.set_ylabel("median above pedestal [DN]")
    above = ax.secondary_xaxis(
        "top",
        functions=(lambda v: 1000 / np.maximum(v, 0.1) - KELVIN, lambda c: 1000 / (c + KELVIN)),
    )
    ticks = sorted({s.point.temperature_c for s in warm})
    ticks = ticks if len(ticks) <= 5 else ticks[:: math.ceil(len(ticks) / 4)]
    above.set_xticks(ticks, [f"{t:.3g} °C" for t in ticks])
    above.tick_params(labelsize=7, length=2, color="#8a929b")
    above.spines["top"].set_visible(False)
    ax.set_title("dark signal", pad=18)


def _law(ax: Any, layer: Layer, warm: Sequence[Any], pedestal: float) -> None:
    """The measured Arrhenius line with its activation energy written beside it."""
    trend = layer.statistics.trends.get("activation_energy_ev")
    if trend is None or not is_number(trend.value):
        return
    seen = [(s.point.temperature_c + KELVIN, s.values["median"].value - pedestal) for s in warm]
    seen = [(t, y) for t, y in seen if y > 0]
    if not seen:
        return
    hottest = max(seen)
    kelvin = np.linspace(min(t for t, _ in seen), hottest[0], 50)
    line = hottest[1] * np.exp(-trend.value / BOLTZMANN_EV * (1 / kelvin - 1 / hottest[0]))
    ax.plot(1000 / kelvin, line, color=ACCENT, linewidth=1.0, linestyle=(0, (1, 2)))
    ax.annotate(
        f"{with_error(trend.value, trend.se)} eV" + ("?" if unusual(trend.value, trend.se) else ""),
        (1000 / kelvin[25], line[25]), xytext=(8, 8), textcoords="offset points", color=ACCENT,
    )  # fmt: skip


def _noise(ax: Any, drawn: Sequence[Layer], warm: Sequence[Any], name: str, title: str) -> None:
    celsius = np.array([s.point.temperature_c for s in warm], float)
    for layer in drawn:
        values = [getattr(layer.like(s), "values", {}).get(name) for s in warm]
        y = np.array([v.value if v is not None else math.nan for v in values], float)
        seen = np.isfinite(y)
        if seen.any():
            ax.plot(
                celsius[seen], y[seen], marker="o", markersize=3.2, color=layer.colour,
                linestyle=layer.dash, linewidth=layer.width,
            )  # fmt: skip
    ax.set_title(title)
    ax.set_xlabel("°C")
    ax.set_ylabel("DN")
    if ax.lines:
        ax.set_yscale("log")
        log_axis(ax.yaxis)
    else:
        ax.text(0.05, 0.5, "single frames do not tell it", transform=ax.transAxes, color=MODEL)
