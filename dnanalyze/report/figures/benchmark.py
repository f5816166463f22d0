"""Sensors side by side: their figures over temperature with their laws, and what models leave."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.benchmarking.criteria import Criterion
from dnanalyze.benchmarking.run import BenchmarkResult
from dnanalyze.benchmarking.sensor_record import SensorRecord
from dnanalyze.benchmarking.temperature_laws import Reading
from dnanalyze.report.figures.palette import ROSE, SKY
from dnanalyze.report.figures.style import (
    ACCENT,
    GAUSSIAN,
    HAIRLINE,
    INK,
    MODEL,
    Cell,
    Picture,
    curve,
    frequency_axis,
    log_axis,
    panels,
    quantity,
    thinned,
)
from dnanalyze.report.words import number

COLOURS = (MODEL, GAUSSIAN, ACCENT, ROSE, SKY, INK)  # from the seventh sensor on the dashes change
KINDS = (
    ("gaussian", "Gaussian model", GAUSSIAN),
    ("paper", "Wang 2025 model", MODEL),
    ("refined", "refined model", ACCENT),
)
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.5)))
PANELS = ("dark_current", "temporal_noise", "dsnu", "hot_pixels", "row_noise", "column_noise")


def look_of(place: int, name: str) -> dict[str, Any]:
    """Colour, dash and name of a sensor, the same in every figure."""
    return {
        "label": name,
        "color": COLOURS[place % len(COLOURS)],
        "linestyle": DASHES[place // len(COLOURS) % len(DASHES)],
    }


def draw_criterion(ax: Any, result: BenchmarkResult, criterion: Criterion) -> Any:
    """Readings and law of each sensor over temperature, the common temperatures marked.

    Parameters
    ----------
    ax : matplotlib axes
    result : Benchmark
    criterion : Criterion
        One of `dnanalyze.benchmarking.criteria.CRITERIA`.
    """
    for place, sensor in enumerate(result.sensors):
        _series(ax, sensor.readings[criterion.name], criterion, result, look_of(place, sensor.name))
    if not ax.has_data():
        return ax
    for celsius in result.temperatures:
        ax.axvline(celsius, color=HAIRLINE, linewidth=1.0, zorder=0)
    ax.set_title(criterion.title)
    ax.set_xlabel("temperature [°C]")
    ax.set_ylabel(quantity(criterion.title, criterion.unit))
    ax.set_yscale("log")
    log_axis(ax.yaxis)
    return ax


def over_temperature(result: BenchmarkResult) -> Picture | None:
    """One panel a figure of merit."""
    from dnanalyze.benchmarking.criteria import CRITERIA

    def cell(criterion: Criterion) -> Cell:
        return Cell(lambda ax: draw_criterion(ax, result, criterion), 3.35, 2.6)

    return panels(
        [cell(c) for c in CRITERIA if c.name in PANELS],
        "Points: measured, with standard errors. Lines: the law of each sensor, with its "
        "uncertainty. Grey verticals: the temperatures of the tables.",
        "Dark current, noises, DSNU and hot pixels of each sensor over temperature, with laws.",
    )


def _series(
    ax: Any,
    readings: Sequence[Reading],
    criterion: Criterion,
    result: BenchmarkResult,
    look: dict[str, Any],
) -> None:
    from dnanalyze.benchmarking.run import EXTRAPOLATION
    from dnanalyze.benchmarking.temperature_laws import estimate

    good = [r for r in readings if r.value > 0]
    if not good:
        return
    t, y, se = np.array([(r.temperature_c, r.value, r.se) for r in good]).T
    low = np.maximum(y - se, y / 3)
    ax.errorbar(
        t, y, yerr=[y - low, se], fmt="o", markersize=3.2, color=look["color"], elinewidth=0.8
    )  # fmt: skip
    if t.size < 2:
        ax.plot([], [], **look)  # its name
        return
    common = result.temperatures
    reach = EXTRAPOLATION * float(np.ptp(t))
    low, high = min([t.min(), *common]), max([t.max(), *common])
    grid = np.linspace(max(low, t.min() - reach), min(high, t.max() + reach), 40)
    laws = [estimate(readings, float(c), criterion.floor) for c in grid]
    keep = [k for k, law in enumerate(laws) if law is not None]
    value = np.array([laws[k].value for k in keep])  # type: ignore[union-attr]
    error = np.array([laws[k].se / laws[k].value for k in keep])  # type: ignore[union-attr]
    ax.plot(grid[keep], value, linewidth=1.1, **look)
    wide = np.minimum(error, 1.5)
    ax.fill_between(
        grid[keep], value * np.exp(-wide), value * np.exp(wide), color=look["color"], alpha=0.12,
        linewidth=0,
    )  # fmt: skip


def draw_errors(ax: Any, result: BenchmarkResult) -> Any:
    """Errors of the Gaussian, the Wang 2025 and the refined model of each sensor."""
    if not any(s.errors for s in result.sensors):
        return ax
    named = set()
    for row, sensor in enumerate(result.sensors):
        for step, (kind, label, colour) in enumerate(KINDS):
            if kind in sensor.errors:
                y = row + 0.22 * (step - 1)
                ax.plot(sensor.errors[kind], y, "o", color=colour, markersize=6,
                        label="_" * (kind in named) + label)  # fmt: skip
                ax.annotate(number(sensor.errors[kind]), (sensor.errors[kind], y), (7, 0),
                            textcoords="offset points", va="center", fontsize=7.2)  # fmt: skip
                named.add(kind)
    ax.set_yticks(range(len(result.sensors)), [s.name for s in result.sensors])
    ax.set_ylim(len(result.sensors) - 0.4, -0.6)
    ax.set_xscale("log")
    ax.margins(x=0.16)
    log_axis(ax.xaxis)
    ax.axvline(1.0, color=INK, linewidth=0.8, linestyle=(0, (3, 2)))
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("model error (dimensionless)")
    return ax


def errors(result: BenchmarkResult) -> Picture | None:
    """The errors as a picture."""
    return panels(
        [Cell(lambda ax: draw_errors(ax, result), 4.4, 0.8 + 0.62 * len(result.sensors))],
        "Model error of each sensor. Dashed line: 1, a second sensor of the same design.",
        "Errors of three models for each sensor.",
    )


def draw_spectra(ax: Any, result: BenchmarkResult) -> Any:
    """Radial spectra at the hottest setting, over the high-frequency power of each sensor."""
    for place, sensor in enumerate(result.sensors):
        found = _spectrum(sensor)
        if found is not None:
            ax.plot(*thinned(*found, 200), **look_of(place, sensor.name))
    if ax.lines:
        ax.set_yscale("log")
        log_axis(ax.yaxis)
        frequency_axis(ax, "radial frequency [cycles/pixel]")
        ax.set_ylabel("power / median power above 0.25 c/px")
    return ax


def _spectrum(sensor: SensorRecord) -> tuple[np.ndarray, np.ndarray] | None:
    """Frequency and relative power of the mean frame, else of a single frame."""
    hottest = max(
        sensor.statistics.settings,
        key=lambda s: (s.point.temperature_c or 0.0, s.point.exposure_s or 0.0),
    )
    for name in ("pattern", "frame"):
        found = curve(hottest, f"{name}_radial_f", f"{name}_radial_s")
        if found is None:
            continue
        f, p = found
        good = (f > 0) & (p > 0)
        if good.any():
            high = good & (f > 0.25)
            return f[good], p[good] / (np.median(p[high]) if high.any() else p[good][-1])
    return None


def spectra(result: BenchmarkResult) -> Picture | None:
    """The spectra as a picture."""
    return panels(
        [Cell(lambda ax: draw_spectra(ax, result), 4.4, 3.0)],
        "Radial power spectrum of the DSNU at the hottest operating point of each sensor, whole "
        "rows and columns left out, divided by its high-frequency power: white noise is flat, "
        "1/f noise rises to the left.",
        "Radial power spectra of each sensor.",
    )
