"""What the figures share: layers, the operating points that they show, axes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.digits import symbol
from dnanalyze.loaders.captures import Setting
from dnanalyze.report.figures.palette import (
    ACCENT,
    GAUSSIAN,
    HAIRLINE,
    INK,
    MODEL,
    PAPER,
    QUIET,
)
from dnanalyze.report.figures.pictures import Cell, Picture, panels
from dnanalyze.report.figures.rc_params import styled
from dnanalyze.report.figures.ticks import frequency_axis, log_axis, power_label
from dnanalyze.report.words import point_label, varied

__all__ = [
    "ACCENT", "GAUSSIAN", "HAIRLINE", "INK", "MODEL", "PAPER", "QUIET", "Cell", "Layer", "Picture",
    "axis_of", "chosen", "curve", "frequency_axis", "has", "labels", "layers", "log_axis",
    "main_run", "one_plane", "panels", "plane_note", "power_label", "quantity", "runs",
    "styled", "thinned", "unframed",
]  # fmt: skip


@dataclass(frozen=True)
class Layer:
    """One set of statistics and how it is drawn wherever it appears."""

    label: str
    statistics: Statistics
    colour: str = INK
    dash: Any = "-"
    width: float = 1.3
    band: bool = False

    def like(self, setting: SettingStatistics) -> SettingStatistics | None:
        """The statistics of the same operating point and colour plane."""
        for own in self.statistics.settings:
            if own.point == setting.point and own.plane == setting.plane:
                return own
        return None

    @property
    def line(self) -> dict[str, Any]:
        """How matplotlib is to draw and name it."""
        return {
            "color": self.colour,
            "linestyle": self.dash,
            "linewidth": self.width,
            "label": self.label,
        }


def layers(
    measured: Statistics, simulated: Statistics | None = None, gaussian: Statistics | None = None
) -> tuple[Layer, ...]:
    """Measured, Gaussian and model, in the order in which they are drawn."""
    beneath = 1.4 if simulated is None else 2.2  # so that it shows on both sides of the model
    made = [Layer("measured", measured, INK, "-", beneath, band=True)]
    if gaussian is not None:
        made.append(Layer("Gaussian", gaussian, GAUSSIAN, (0, (4, 2)), 1.0))
    if simulated is not None:
        made.append(Layer("model", simulated, MODEL, "-", 1.2))
    return tuple(made)


def one_plane(statistics: Statistics) -> list[SettingStatistics]:
    """Settings of the first colour plane."""
    return [s for s in statistics.settings if s.plane == statistics.settings[0].plane]


AXES = (("temperature_c", "temperature [°C]"), ("exposure_s", "exposure [s]"), ("gain", "gain"))
ORDER = "operating point"  # the axis of settings that differ in nothing that has an axis


def axis_of(settings: Sequence[SettingStatistics]) -> tuple[str, np.ndarray, str]:
    """What the settings are drawn over: its key, the values, a label.

    The part of the operating point that takes the most values while the others stay.
    """
    best, most = ("", np.arange(1.0, len(settings) + 1), ORDER), 1
    for key, label in AXES:
        values = [getattr(s.point, key) for s in settings]
        if None in values:
            continue
        longest = max((len({values[n] for n in run}) for run in _along(settings, key)), default=0)
        if longest > most:
            best, most = (key, np.array(values, float), label), longest
    return best


def _along(settings: Sequence[SettingStatistics], key: str) -> list[list[int]]:
    """Indices of the settings that differ in ``key`` alone."""
    found: dict[tuple[Any, ...], list[int]] = {}
    for n, setting in enumerate(settings):
        rest = tuple(v for k, v in vars(setting.point).items() if k != key)
        found.setdefault(rest, []).append(n)
    return list(found.values())


def runs(settings: Sequence[SettingStatistics]) -> list[list[int]]:
    """Indices of the settings that differ in the axis alone, each run along it; longest first.

    Among runs of one length the longest exposure and the warmest come first: they show the most
    dark signal.
    """
    key, x, _ = axis_of(settings)
    if not key:
        return [list(range(len(settings)))]
    made = [sorted(run, key=lambda n: x[n]) for run in _along(settings, key)]

    def rank(run: list[int]) -> tuple[float, ...]:
        point = settings[run[0]].point
        return -len(run), -(point.exposure_s or 0), -(point.temperature_c or -math.inf)

    return sorted(made, key=rank)


Can = Callable[[SettingStatistics], bool]


def main_run(statistics: Statistics, can: Can = lambda _: True) -> list[SettingStatistics]:
    """The longest run, in one colour plane, of the settings that can tell what is asked."""
    if not statistics.settings:
        return []
    own = [s for s in one_plane(statistics) if can(s)]
    return [own[n] for n in runs(own)[0]] if own else []


def chosen(
    statistics: Statistics, most: int = 5, can: Can = lambda _: True
) -> list[SettingStatistics]:
    """Settings to draw side by side: spread evenly over the main run of those that can tell it."""
    own = main_run(statistics, can)
    if len(own) <= most:
        return own
    places = np.linspace(len(own) - 1, 0, most).round().astype(int)  # one alone is the last
    return [own[n] for n in places[::-1]]


def has(*names: str) -> Can:
    """Whether a setting has these curves."""
    return lambda setting: curve(setting, *names) is not None


def labels(settings: Sequence[SettingStatistics | Setting]) -> list[str]:
    """Short titles of settings: only what differs between them."""
    only = varied(vars(s.point) for s in settings)
    return [point_label(s.point, only) for s in settings]


def plane_note(statistics: Statistics, shown: Sequence[SettingStatistics] | None = None) -> str:
    """Says what a figure shows where there is more: one colour plane, one exposure, ..."""
    own = one_plane(statistics)
    shown = main_run(statistics) if shown is None else shown
    note = ""
    if len(own) < len(statistics.settings):
        note += f" Colour plane {own[0].plane}."
    if shown and len(shown) < len(own):
        apart = varied(vars(s.point) for s in own) - varied(vars(s.point) for s in shown)
        note += f" Shown: {point_label(shown[0].point, apart)}." if apart else ""
    return note + " The tables have every operating point." if note else ""


def by_setting(
    drawn: Sequence[Layer], draw: Callable[..., Any], can: Can, texts: tuple[str, str], **size: Any
) -> Picture | None:
    """One panel an operating point, up to three.

    Parameters
    ----------
    drawn : sequence of Layer
        The measured first.
    draw : callable
        Called with axes, ``drawn`` and ``setting``.
    can : callable
        Whether a setting has what is drawn.
    texts : (str, str)
        Caption and description of the picture.
    size : Any
        Of each `Cell`.
    """
    measured = drawn[0].statistics
    settings = chosen(measured, 3, can)

    cells = [
        Cell(partial(draw, drawn=drawn, setting=s), title=t, **size)
        for s, t in zip(settings, labels(settings), strict=True)
    ]
    return panels(cells, texts[0] + plane_note(measured, settings), texts[1])


def quantity(text: str, unit: str) -> str:
    """Label of an axis: what it holds and its unit."""
    shown = symbol(unit.replace("c/px", "cycles/pixel"))
    return f"{text} [{shown}]" if shown else text


def curve(setting: SettingStatistics | None, *names: str) -> tuple[np.ndarray, ...] | None:
    """Curves of these names as float arrays, None where one is absent or empty."""
    if setting is None:
        return None
    found = []
    for name in names:
        values = setting.curves.get(name)
        if values is None or np.size(values) == 0:
            return None
        found.append(np.asarray(values, dtype=float))
    return tuple(found)


def thinned(x: np.ndarray, y: np.ndarray, most: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Means over runs of neighbours, so that a long curve stays light; the ends are kept."""
    if len(x) <= most:
        return x, y
    edges = np.unique(np.linspace(0, len(x), most + 1).astype(int))
    counts = np.diff(edges)
    return np.add.reduceat(x, edges[:-1]) / counts, np.add.reduceat(y, edges[:-1]) / counts


def unframed(ax: Any) -> Any:
    """An image without grid, ticks and frame."""
    ax.grid(visible=False)
    ax.set(xticks=[], yticks=[])
    ax.spines[:].set_visible(False)
    return ax


def shown_layers(drawn: Iterable[Layer]) -> list[Layer]:
    """Without the Gaussian, where it has nothing to say beside the model."""
    return [k for k in drawn if k.label != "Gaussian"]
