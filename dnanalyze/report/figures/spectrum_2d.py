"""The two-dimensional spectra: a direction shows as a line, a frequency as a spot."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.report.figures.colour_bar import bar_cell
from dnanalyze.report.figures.style import (
    Cell,
    Layer,
    Picture,
    chosen,
    curve,
    labels,
    panels,
    plane_note,
    shown_layers,
)

PARTS = {"pattern": "DSNU", "temporal": "temporal noise"}
DARKEST, BRIGHTEST = -8.0, 14.0  # dB about the median that the colours span
WIDEST = 90  # columns of half a plane that a panel can show
BAR = "power / median power [dB]"


def draw_plane(ax: Any, setting: SettingStatistics | None, part: str = "pattern") -> Any:
    """Power over horizontal (u) and vertical (v) frequency, dB about its median.

    Parameters
    ----------
    part : str
        "pattern" (DSNU) or "temporal" (temporal dark noise).
    """
    power = _plane(setting, part)
    if power is None:
        return ax
    rows, columns = power.shape
    dv, du = 0.5 / (rows - 1), 0.5 / (columns - 1)  # half a cell: the outermost are centred on .5
    ax.grid(visible=False)
    # whole decibels: finer steps cannot be seen, and make a picture of noise ten times as heavy
    ax.imshow(
        np.rint(power), vmin=DARKEST, vmax=BRIGHTEST, aspect="auto", origin="lower",
        extent=(-0.5 - du, 0.5 + du, -0.5 - dv, 0.5 + dv),
    )  # fmt: skip
    ax.set_xticks([-0.5, 0, 0.5])
    ax.set_yticks([-0.5, 0, 0.5])
    ax.set_xlabel("u [cycles/pixel]")
    ax.set_ylabel("v [cycles/pixel]")
    return ax


def planes(drawn: Sequence[Layer]) -> Picture | None:
    """Measured and model at the coldest and the warmest setting, with one colour bar."""
    measured = drawn[0].statistics

    cells: list[Cell] = []
    shown: list[Any] = []
    for part in PARTS:
        found = chosen(measured, 2, lambda s, p=part: _plane(s, p) is not None)  # type: ignore[misc]
        shown = found or shown
        for setting, title in zip(found, labels(found), strict=True):
            for layer in shown_layers(drawn):
                name = f"\n{layer.label}" if len(drawn) > 1 else ""
                draw = partial(draw_plane, setting=layer.like(setting), part=part)
                cells.append(Cell(draw, 2.2, 2.15, title=f"{PARTS[part]}, {title}{name}"))
    if not cells:
        return None
    return panels(
        [*cells, bar_cell(BAR, DARKEST, BRIGHTEST)],
        "Power over the horizontal (u) and the vertical frequency (v), from Nyquist to Nyquist. "
        "Nonuniformity of whole columns is a bright horizontal line at v = 0, of whole rows a "
        "vertical one at u = 0, an interference a pair of spots, a smoothing filter a darkening "
        "outwards." + plane_note(measured, shown),
        "Two-dimensional power spectra.",
    )


def _plane(setting: SettingStatistics | None, part: str) -> np.ndarray | None:
    """The plane in dB about its median, from -1/2 to 1/2 in both directions, ends included.

    Kept is the half u >= 0; the other is the same turned by 180 degrees.
    """
    found = curve(setting, f"{part}_psd2d")
    if found is None or found[0].ndim != 2:
        return None
    power = found[0]
    if power.shape[1] > WIDEST:  # pairs of columns, u = 0 by itself: whole rows stay a sharp line
        starts = [0, *range(1, power.shape[1], 2)]
        counts = np.diff([*starts, power.shape[1]])
        power = np.log10(np.add.reduceat(10**power, starts, axis=1) / counts)
    right = 10 * (power - np.median(power))
    right = np.vstack([right, right[:1]])  # v = 1/2 is v = -1/2
    return np.hstack([right[::-1, :0:-1], right])
