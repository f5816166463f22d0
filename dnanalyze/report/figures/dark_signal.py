"""Mean dark signal over exposure and temperature, dark current, photon transfer, each with its fit.

Panels that the captures cannot fill are not drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from dnanalyze.emva.quantity import DarkCurrent, Emva, Group
from dnanalyze.report.figures.style import (
    ACCENT,
    GAUSSIAN,
    INK,
    MODEL,
    Cell,
    Picture,
    log_axis,
    panels,
)
from dnanalyze.report.words import number, with_error
from dnanalyze.thermal import KELVIN, activation, over_constant

COLOURS = (MODEL, GAUSSIAN, ACCENT, "#cc79a7", "#e69f00", INK)
MOST_LINES = 6
Panel = Callable[[Any], None]


def dark_signal(found: Emva) -> Picture | None:
    """Of the group with most operating points; None where a single operating point is all."""
    if not found.groups:
        return None
    group = max(found.groups, key=lambda g: len(g.points))
    drawn = (_exposure(group), _temperature(group), _current(group), _transfer(group))
    named = f" {group.label}." if len(found.groups) > 1 else ""
    return panels(
        [Cell(draw, 3.35, 2.9) for draw in drawn if draw is not None],
        "Points: measured, with standard errors (often smaller than the point); lines: the fits of "
        f"the table.{named}",
        "Mean dark signal over exposure and temperature, and the dark current, with fits.",
    )


def _exposure(group: Group) -> Panel | None:
    lines = [d for d in group.dark_currents if d.mean_line is not None]
    if not lines:
        return None
    step = max(1, -(-len(lines) // MOST_LINES))
    some = lines[::-step]

    def draw(ax: Any) -> None:
        for colour, current in zip(COLOURS, some, strict=False):
            fit = current.mean_line
            assert fit is not None
            label = "" if current.temperature_c is None else f"{number(current.temperature_c)} °C"
            ax.errorbar(
                fit.x, fit.y, fit.error, fmt="o", markersize=3.4, color=colour, linewidth=0.9,
                label=label,
            )  # fmt: skip
            ends = np.array([0.0, max(fit.x)])
            ax.plot(ends, fit.intercept.value + fit.slope.value * ends, color=colour, linewidth=1)
        if any(d.temperature_c is not None for d in some):
            ax.legend(loc="upper left", handlelength=1.2)
        ax.set_xlabel("exposure [s]")
        ax.set_ylabel("mean dark signal [DN]")
        ax.set_title("over exposure")

    return draw


def _temperature(group: Group) -> Panel | None:
    by_exposure: dict[float | None, list[tuple[float, float, float]]] = {}
    for p in group.points:
        mean = p.quantities["mean_dark_signal_dn"]
        if p.point.temperature_c is not None and mean.value is not None and mean.se is not None:
            by_exposure.setdefault(p.point.exposure_s, []).append(
                (p.point.temperature_c, mean.value, mean.se)
            )
    runs = {e: sorted(run) for e, run in by_exposure.items() if _apart([t for t, _, _ in run])}
    if not runs:
        return None
    longest = sorted(runs, key=lambda e: (-len(runs[e]), -(e or 0)))[:3]
    energy = group.quantities["activation_energy_ev"].value

    def draw(ax: Any) -> None:
        for colour, exposure in zip(COLOURS, longest, strict=False):
            t, y, se = np.array(runs[exposure]).T
            label = "" if exposure is None else f"{number(exposure)} s"
            ax.errorbar(t, y, se, fmt="o", markersize=3.4, color=colour, linewidth=0.9, label=label)
            if energy is not None and len(t) > 2:
                at, fit = _law_over_offset(t, y, energy)
                ax.plot(at, fit, color=colour, linewidth=1)
        if any(e is not None for e in longest):
            ax.legend(loc="upper left", handlelength=1.2)
        ax.set_xlabel("temperature [°C]")
        ax.set_ylabel("mean dark signal [DN]")
        ax.set_title("over temperature")

    return draw


def _law_over_offset(
    celsius: np.ndarray, level: np.ndarray, energy_ev: float
) -> tuple[np.ndarray, np.ndarray]:
    """An Arrhenius law of this energy above a constant, by least squares, to be drawn."""
    at = np.linspace(celsius.min(), celsius.max(), 60)
    x = activation(celsius + KELVIN, float(celsius.max()) + KELVIN)
    even = np.ones_like(level)
    found = over_constant(x, even, level, even, np.full(2, energy_ev))
    drawn = activation(at + KELVIN, float(celsius.max()) + KELVIN)
    return at, found.constant + found.size * np.exp(energy_ev * drawn)


def _rates(currents: Sequence[DarkCurrent]) -> list[tuple[float, float, float]]:
    out = []
    for current in currents:
        rate = current.quantities["dark_current_mean_dn_s"]
        if current.temperature_c is None or rate.value is None or rate.se is None:
            continue
        if rate.value > 2 * rate.se:
            out.append((current.temperature_c, rate.value, rate.se))
    return sorted(out)


def _current(group: Group) -> Panel | None:
    rates = _rates(group.dark_currents)
    if not _apart([t for t, _, _ in rates]):
        return None
    step, energy = (group.quantities[k] for k in ("doubling_temperature_c", "activation_energy_ev"))

    def draw(ax: Any) -> None:
        t, y, se = np.array(rates).T
        ax.errorbar(t, y, se, fmt="o", markersize=3.4, color=MODEL, linewidth=0.9)
        if step.value is not None and energy.value is not None:
            at = np.linspace(t.min(), t.max(), 60)
            x, drawn = (energy.value * activation(v + KELVIN, KELVIN) for v in (t, at))
            level = np.average(np.log(y) - x, weights=(se / y + 0.02) ** -2.0)
            ax.plot(at, np.exp(level + drawn), color=INK, linewidth=1)
            text = f"doubling every {with_error(step.value, step.se)} °C"
            ax.text(0.04, 0.95, text, transform=ax.transAxes, va="top")
        ax.set_yscale("log")
        log_axis(ax.yaxis)
        ax.set_xlabel("temperature [°C]")
        ax.set_ylabel("dark current [DN/s]")
        ax.set_title("dark current")

    return draw


def _transfer(group: Group) -> Panel | None:
    fit = group.transfer
    if fit is None:
        return None

    def draw(ax: Any) -> None:
        ax.errorbar(fit.x, fit.y, fit.error, fmt="o", markersize=3.4, color=MODEL, linewidth=0.9)
        ends = np.array([min(fit.x), max(fit.x)])
        ax.plot(ends, fit.intercept.value + fit.slope.value * ends, color=INK, linewidth=1)
        text = f"K = {with_error(fit.slope.value, fit.slope.se)} DN/e⁻"
        ax.text(0.04, 0.95, text, transform=ax.transAxes, va="top")
        ax.set_xlabel("mean dark signal [DN]")
        ax.set_ylabel("temporal variance [DN²]")
        ax.set_title("photon transfer in the dark")

    return draw


def _apart(values: Sequence[float]) -> bool:
    """Whether there are two temperatures that a drawing tells apart."""
    return len(values) > 1 and max(values) - min(values) >= 1.0
