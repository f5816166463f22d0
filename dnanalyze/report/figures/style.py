"""How every figure looks, and how it becomes part of a page."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.errors import InputError
from dnanalyze.report.words import point_label, varied

# Okabe and Ito's palette: told apart by every kind of colour vision, and by lightness in grey.
INK, MODEL, GAUSSIAN, ACCENT, QUIET = "#1f2328", "#0072b2", "#d55e00", "#009e73", "#8a929b"
HAIRLINE, PAPER = "#d9dee3", "#ffffff"
WIDTH = 10.4  # inch: the width of the page's column
STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 6,
    "axes.labelsize": 8.0,
    "axes.labelcolor": "#3d444d",
    "axes.edgecolor": "#8a929b",
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#eceff2",
    "grid.linewidth": 0.7,
    "xtick.color": "#59636e",
    "ytick.color": "#59636e",
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "xtick.major.size": 3,
    "ytick.major.size": 3,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.visible": False,
    "ytick.minor.visible": False,
    "lines.linewidth": 1.3,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "text.color": "#1f2328",
    "svg.fonttype": "none",
    "figure.facecolor": "none",
    "axes.facecolor": "#ffffff",
    "image.cmap": "cividis",
    "path.simplify_threshold": 0.5,
}
PAGE_FONT = "'Helvetica Neue', 'Liberation Sans', Arial, sans-serif"


@dataclass(frozen=True)
class Picture:
    """A figure ready for a page: SVG text, a caption, and words for who cannot see it."""

    svg: str
    caption: str
    alt: str


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


def axis_of(settings: Sequence[SettingStatistics]) -> tuple[str, np.ndarray, str]:
    """What the settings are drawn over: its key, the values, a label."""
    for key, label in (("temperature_c", "°C"), ("exposure_s", "exposure [s]"), ("gain", "gain")):
        values = [getattr(s.point, key) for s in settings]
        if None not in values and len(set(values)) > 1:
            return key, np.array(values, float), label
    return "", np.arange(1.0, len(settings) + 1), "operating point"


def runs(settings: Sequence[SettingStatistics]) -> list[list[int]]:
    """Indices of the settings that differ in the axis alone, each run along it; longest first.

    Among runs of one length the longest exposure comes first: it shows the most dark signal.
    """
    key, x, _ = axis_of(settings)
    if not key:
        return [list(range(len(settings)))]
    found: dict[tuple[Any, ...], list[int]] = {}
    for n, setting in enumerate(settings):
        found.setdefault(tuple(v for k, v in vars(setting.point).items() if k != key), []).append(n)
    made = [sorted(run, key=lambda n: x[n]) for run in found.values()]
    return sorted(made, key=lambda run: (-len(run), -(settings[run[0]].point.exposure_s or 0)))


def main_run(statistics: Statistics) -> list[SettingStatistics]:
    """The longest run of settings over temperature (else exposure, gain) in one colour plane."""
    if not statistics.settings:
        return []
    own = one_plane(statistics)
    return [own[n] for n in runs(own)[0]]


def chosen(statistics: Statistics, most: int = 5) -> list[SettingStatistics]:
    """Settings to draw side by side: spread evenly over the main run."""
    own = main_run(statistics)
    if len(own) <= most:
        return own
    return [own[round(i * (len(own) - 1) / (most - 1))] for i in range(most)]


def labels(settings: Sequence[SettingStatistics]) -> list[str]:
    """Short titles of settings: only what differs between them."""
    only = varied(vars(s.point) for s in settings)
    return [point_label(s.point, only) for s in settings]


def plane_note(statistics: Statistics) -> str:
    """Says what a figure shows where there is more: one colour plane, one exposure, ..."""
    own, shown = one_plane(statistics), main_run(statistics)
    note = ""
    if len(own) < len(statistics.settings):
        note += f" Colour plane {own[0].plane}."
    if len(shown) < len(own):
        apart = varied(vars(s.point) for s in own) - varied(vars(s.point) for s in shown)
        note += f" Shown: {point_label(shown[0].point, apart)}."
    return note + " The rest is in the numbers." if note else ""


@contextmanager
def styled() -> Iterator[None]:
    """The style, for the time of drawing only."""
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        yield


def figure(rows: int, columns: int, height: float, width: float = WIDTH, **options: Any) -> Any:
    """A figure and its axes as a 2-D array: a new one, or the user's within `drawn_on`."""
    from matplotlib.figure import Figure

    canvas = _CANVAS.get()
    if canvas is not None:
        return canvas, canvas.divided(rows, columns, height, width, **options)
    fig = Figure(figsize=(width, height), layout="constrained")
    engine: Any = fig.get_layout_engine()
    engine.set(w_pad=0.08, h_pad=0.06, wspace=0.02, hspace=0.04)
    return fig, fig.subplots(rows, columns, squeeze=False, **options)


class Canvas:
    """The user's own axes, or a new pyplot figure, in the place of a page's figure.

    Parameters
    ----------
    ax : matplotlib.axes.Axes or None
    """

    def __init__(self, ax: Any) -> None:
        self.ax = ax
        self.axes: list[Any] = []

    def divided(self, rows: int, columns: int, height: float, width: float, **options: Any) -> Any:
        """So many axes as a 2-D array: one is the user's own, several divide its place."""
        from matplotlib import pyplot

        self.fig = (
            self.ax.figure
            if self.ax is not None
            else pyplot.figure(figsize=(width, height), layout="constrained")
        )
        if self.ax is None:
            made = self.fig.subplots(rows, columns, squeeze=False, **options)
        elif rows == columns == 1:
            made = np.array([[self.ax]])
        else:
            made = self._within(rows, columns, **options)
        self.axes += list(made.ravel())
        return made

    def _within(self, rows: int, columns: int, **options: Any) -> Any:
        """Axes in the place of the user's one, which stays as an empty frame around them."""
        place = self.ax.get_subplotspec()
        if place is None:
            raise InputError(
                "ax: this kind has several panels; give axes of a grid (plt.subplots), or none"
            )
        self.ax.set_axis_off()
        ratios = options.pop("gridspec_kw", {})
        return place.subgridspec(rows, columns, **ratios).subplots(squeeze=False, **options)

    def legend(self, *arguments: Any, **options: Any) -> Any:
        """Above a figure of its own; within the first axes where the figure is the user's."""
        if self.ax is None:
            return self.fig.legend(*arguments, **options)
        kept = {k: v for k, v in options.items() if k in ("handles", "labels", "handlelength")}
        return self.axes[0].legend(*arguments, **kept)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.fig, name)


_CANVAS: ContextVar[Canvas | None] = ContextVar("canvas", default=None)


@contextmanager
def drawn_on(ax: Any = None) -> Iterator[list[Any]]:
    """Within the block figures are drawn on ``ax``, or by pyplot; gives the axes that were made.

    Parameters
    ----------
    ax : matplotlib.axes.Axes, optional
    """
    canvas = Canvas(ax)
    token = _CANVAS.set(canvas)
    try:
        yield canvas.axes
    finally:
        _CANVAS.reset(token)


def picture(draw: Callable[[], Any], caption: str, alt: str) -> Picture | None:
    """Draw in the style and give the SVG; None where ``draw`` had nothing to show."""
    with styled():
        fig = draw()
        if fig is None:
            return None
        if _CANVAS.get() is not None:
            return Picture("", caption, alt)
        stream = io.StringIO()
        fig.savefig(stream, format="svg", metadata={"Date": None, "Creator": None}, dpi=150)
    svg = stream.getvalue()
    svg = svg[svg.index("<svg") :].replace("'DejaVu Sans'", PAGE_FONT)
    return Picture(re.sub(r"\n\s*", "\n", svg), caption, alt)


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def power_label(value: float, _position: int = 0) -> str:
    """Tick of a log axis without mathematics fonts: 0.01, 100, 10⁵."""
    if value <= 0:
        return ""
    exponent = round(math.log10(value))
    if not math.isclose(value, 10.0**exponent, rel_tol=1e-6):
        return f"{value:g}"
    return f"{value:g}" if -3 <= exponent <= 3 else "10" + str(exponent).translate(_RAISED)


def log_axis(axis: Any) -> None:
    """Ticks at powers of ten in plain text; at 1, 2, 5 where the axis spans little."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    low, high = axis.get_view_interval()
    decades = math.log10(high / low) if low > 0 and high > low else 1.0
    subs = (1.0, 2.0, 5.0) if decades < 1.7 else (1.0,)
    axis.set_major_locator(LogLocator(10, subs=subs, numticks=7))
    axis.set_major_formatter(FuncFormatter(power_label))
    axis.set_minor_locator(NullLocator())


def name_layers(fig: Any, drawn: Sequence[Layer]) -> None:
    """One legend for the whole figure, above it."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=k.colour, linestyle=k.dash, linewidth=k.width + 0.2, label=k.label)
        for k in drawn
    ]
    if len(handles) > 1:
        fig.legend(
            handles=handles, loc="outside upper left", ncols=len(handles), handlelength=2.2,
            columnspacing=1.6, borderaxespad=0.2,
        )  # fmt: skip


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
