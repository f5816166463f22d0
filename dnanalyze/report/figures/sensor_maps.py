"""The picture of the sensor: mean dark image, DSNU, hot pixels, one frame, temporal noise."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.emva.reading import biased
from dnanalyze.report.figures.colour_bar import bar_below
from dnanalyze.report.figures.style import Cell, Picture, panels
from dnanalyze.report.words import point_label

HOT = 5.0  # robust standard deviations above the median
WIDE = 1.95  # inch, of a map: five side by side fill the page
TONES = 24  # colours of a map: noise of fewer tones makes a lighter page

Limits = Callable[[np.ndarray, SettingStatistics], tuple[float, float]]


def _spread(values: np.ndarray, setting: SettingStatistics) -> tuple[float, float]:
    """From the 1st to the 99th percentile, and not less than the last digits of the values."""
    low, high = (float(v) for v in np.percentile(values, (1, 99)))
    least = 1e-6 * max(abs(low), abs(high), 1.0)
    return (low, high) if high - low > least else (low - 0.5, low + 0.5)


def _about_zero(values: np.ndarray, setting: SettingStatistics) -> tuple[float, float]:
    top = float(np.percentile(np.abs(values), 99)) or 0.5
    return -top, top


def _from_hot(values: np.ndarray, setting: SettingStatistics) -> tuple[float, float]:
    """From 5 standard deviations to the hottest pixels; below it is paper."""
    core = setting.values.get("pattern_noise_core", setting.values.get("frame_noise_core"))
    low = HOT * (core.value if core is not None else float(np.std(values)))
    above = values[values > low]
    return low, max(float(np.percentile(above, 95)) if above.size else 0.0, 2 * low)


# curve, title, colours, limits
MAPS: tuple[tuple[str, str, str, Limits], ...] = (
    ("picture_mean", "mean dark image", "cividis", _spread),
    ("picture_fixed", "DSNU map", "RdBu_r", _about_zero),
    ("picture_hot", "hot pixels, above median", "YlOrRd", _from_hot),
    ("picture_frame", "one frame", "cividis", _spread),
    ("picture_temporal", "temporal noise", "cividis", _spread),
)


def shown(measured: Statistics) -> SettingStatistics | None:
    """The operating point that is drawn: the highest mean dark signal that is not clipped.

    Of the first colour plane; those of one frame only where there are no others.
    """
    known = [s for s in measured.settings if "picture_mean" in s.curves]
    if not known:
        return None
    own = [s for s in known if s.plane == known[0].plane]

    def rank(setting: SettingStatistics) -> tuple[bool, bool, float]:
        return not biased(setting), setting.frames > 1, setting.values["mean"].value

    return max(own, key=rank)


def sensor_maps(measured: Statistics) -> Picture | None:
    """Five maps side by side, each with its colour bar in DN; None without maps.

    Parameters
    ----------
    measured : Statistics
        Of a full analysis, whose curves hold ``picture_mean`` and the like.
    """
    setting = shown(measured)
    if setting is None:
        return None
    own = [item for item in MAPS if item[0] in setting.curves]
    where = point_label(setting.point) + (f", plane {setting.plane}" if setting.plane else "")
    rows, columns = setting.shape
    plural = "s" if setting.frames > 1 else ""
    height = min(max(WIDE * rows / columns, 0.9), 3.2)

    def cell(name: str, title: str, colours: str, limits: Limits) -> Cell:
        draw = partial(draw_map, setting=setting, name=name, colours=colours, limits=limits)
        return Cell(draw, WIDE, 0.75 + height, title=title)

    return panels(
        [cell(*item) for item in own],
        f"{rows} × {columns} pixels. At {where}, {setting.frames} frame{plural}. Maps of larger "
        "sensors are reduced: cell means (mean dark image), cell rms (temporal noise), the highest "
        "pixel of a cell (hot pixels, from 5 robust standard deviations), one pixel of each cell "
        "(DSNU, with the slow shading taken off, and one frame). Colours end at the 1st and 99th "
        "percentile.",
        "Maps of the sensor: " + ", ".join(title for _, title, _, _ in own),
    )


def draw_map(ax: Any, setting: SettingStatistics, name: str, colours: str, limits: Limits) -> Any:
    """One map of the sensor with its colour bar in DN.

    Parameters
    ----------
    ax : matplotlib axes
    setting : SettingStatistics
    name, colours, limits
        An item of ``MAPS``.
    """
    from matplotlib import colormaps

    rows, columns = setting.shape
    values = np.asarray(setting.curves[name], float)
    low, high = limits(values, setting)
    tones = colormaps[colours].resampled(TONES)
    if limits is _from_hot:
        tones = tones.with_extremes(under="#ffffff")
    image = ax.imshow(
        values, cmap=tones, vmin=low, vmax=high, interpolation="none",
        extent=(0, columns, rows, 0), aspect="equal",
    )  # fmt: skip
    bar_below(ax, image, (low, high), aspect=18, margin=0.08)
    return ax
