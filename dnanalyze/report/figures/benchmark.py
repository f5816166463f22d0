"""Sensors side by side: their figures over temperature with their laws, and what models leave."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.report.figures.style import (
    ACCENT,
    GAUSSIAN,
    HAIRLINE,
    MODEL,
    QUIET,
    Picture,
    figure,
    log_axis,
    picture,
    thinned,
)

# Okabe and Ito's palette; from the sixth sensor on the dashes change
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#1f2328")
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1.5)))
PANELS = ("dark_current", "temporal_noise", "dsnu", "hot_pixels", "row_noise", "column_noise")


def look_of(place: int) -> dict[str, Any]:
    """Colour and dash of a sensor, the same in every figure."""
    return {
        "color": COLOURS[place % len(COLOURS)],
        "linestyle": DASHES[place // len(COLOURS) % len(DASHES)],
    }


def over_temperature(result: Any) -> Picture | None:
    """Readings and laws of each sensor, the common temperatures marked."""
    from dnanalyze.benchmarking.criteria import CRITERIA

    shown = [c for c in CRITERIA if c.name in PANELS]
    if not any(s.readings[c.name] for s in result.sensors for c in shown):
        return None

    def draw() -> Any:
        fig, axes = figure(2, 3, 5.4)
        for ax, criterion in zip(axes.flat, shown, strict=True):
            for place, sensor in enumerate(result.sensors):
                _series(ax, sensor.readings[criterion.name], criterion, result, look_of(place))
            for celsius in result.temperatures:
                ax.axvline(celsius, color=HAIRLINE, linewidth=1.0, zorder=0)
            ax.set_title(f"{criterion.title} [{criterion.unit}]")
            ax.set_xlabel("°C")
            if ax.lines and ax.has_data() and _positive(ax):
                ax.set_yscale("log")
                log_axis(ax.yaxis)
        _legend(fig, result)
        return fig

    return picture(
        draw,
        "Points are measured, lines are each sensor's law, the band its uncertainty; grey "
        "verticals mark the temperatures at which the tables compare.",
        "Dark current, noises, DSNU and hot pixels of each sensor over temperature, with laws.",
    )


def _positive(ax: Any) -> bool:
    return any(np.any(np.asarray(line.get_ydata(), float) > 0) for line in ax.lines[:-1])


def _series(
    ax: Any, readings: Sequence[Any], criterion: Any, result: Any, look: dict[str, Any]
) -> None:
    from dnanalyze.benchmarking.laws import estimate
    from dnanalyze.benchmarking.run import REACH

    good = [r for r in readings if r.value > 0]
    if not good:
        return
    t, y, se = np.array([(r.temperature_c, r.value, r.se) for r in good]).T
    low = np.maximum(y - se, y / 3)
    ax.errorbar(
        t, y, yerr=[y - low, se], fmt="o", markersize=3.2, color=look["color"], elinewidth=0.8
    )  # fmt: skip
    if t.size < 2:
        return
    common = result.temperatures
    reach = REACH * float(np.ptp(t))
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


def errors(result: Any) -> Picture | None:
    """Errors of the Gaussian, the paper's and the refined model of each sensor."""
    kinds = (
        ("gaussian", "plain Gaussian", GAUSSIAN),
        ("paper", "the paper's model", MODEL),
        ("refined", "refined model", ACCENT),
    )
    if not any(s.errors for s in result.sensors):
        return None

    def draw() -> Any:
        fig, axes = figure(1, 1, 0.8 + 0.5 * len(result.sensors))
        ax = axes[0, 0]
        for row, sensor in enumerate(result.sensors):
            for step, (kind, label, colour) in enumerate(kinds):
                if kind in sensor.errors:
                    ax.barh(
                        row + 0.26 * (step - 1), sensor.errors[kind], 0.22, color=colour,
                        label=label if row == 0 else None,
                    )  # fmt: skip
        ax.set_yticks(range(len(result.sensors)), [s.name for s in result.sensors])
        ax.invert_yaxis()
        ax.set_xscale("log")
        log_axis(ax.xaxis)
        ax.axvline(1.0, color=QUIET, linewidth=1.0)
        ax.grid(axis="y", visible=False)
        ax.set_xlabel("error; 1 = as close as a second sensor of the same make")
        fig.legend(loc="outside upper left", ncols=3)
        return fig

    return picture(
        draw,
        "How well each sensor is described, without this tool's additions and with them.",
        "Errors of three models for each sensor.",
    )


def spectra(result: Any) -> Picture | None:
    """Radial spectra of the mean frame at the hottest setting, over the level of each sensor."""
    curves = []
    for sensor in result.sensors:
        hottest = max(
            sensor.statistics.settings,
            key=lambda s: (s.point.temperature_c or 0.0, s.point.exposure_s or 0.0),
        )
        for name in ("pattern", "frame"):
            f = hottest.curves.get(f"{name}_radial_f", np.empty(0))
            p = hottest.curves.get(f"{name}_radial_s", np.empty(0))
            if np.size(p):
                curves.append((sensor.name, hottest.point.label(), np.asarray(f), np.asarray(p)))
                break
        else:
            curves.append((sensor.name, "", np.empty(0), np.empty(0)))
    if not any(c[2].size for c in curves):
        return None

    def draw() -> Any:
        fig, axes = figure(1, 1, 3.2)
        ax = axes[0, 0]
        for place, (_, _, f, p) in enumerate(curves):
            good = (f > 0) & (p > 0)
            if good.any():
                high = np.median(p[good][f[good] > 0.25]) if (f[good] > 0.25).any() else p[good][-1]
                ax.plot(*thinned(f[good], p[good] / high, 200), **look_of(place))
        ax.set_xscale("log")
        ax.set_yscale("log")
        log_axis(ax.xaxis)
        log_axis(ax.yaxis)
        ax.set_xlabel("spatial frequency [cycles/pixel]")
        ax.set_ylabel("power over that beyond 0.25")
        _legend(fig, result)
        return fig

    return picture(
        draw,
        "Radial spectrum of the fixed pattern at each sensor's hottest setting, rows and columns "
        "left out, over its own high-frequency level: white noise is flat, 1/f rises to the left.",
        "Radial power spectra of each sensor.",
    )


def _legend(fig: Any, result: Any) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], label=s.name, linewidth=1.6, **look_of(place))
        for place, s in enumerate(result.sensors)
    ]
    fig.legend(handles=handles, loc="outside upper left", ncols=min(len(handles), 6))
