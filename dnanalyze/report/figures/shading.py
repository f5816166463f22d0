"""The slow shape of the field: block means, measured, of the model, and what is left."""

from __future__ import annotations

from collections.abc import Sequence
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
    unframed,
)

COLOURS = "RdBu_r"
BAR = "block mean − mean [DN]"


def draw_shading(ax: Any, field: np.ndarray, limit: float) -> Any:
    """One map of block means; colours run from minus to plus ``limit`` DN."""
    ax.imshow(field, cmap=COLOURS, vmin=-limit, vmax=limit, aspect="equal")
    return unframed(ax)


def fields(
    drawn: Sequence[Layer], setting: SettingStatistics
) -> tuple[dict[str, np.ndarray], float]:
    """Measured, model and residual by name, DN, and the limit of their common colour scale."""
    found = {k.label: _map(k.like(setting)) for k in shown_layers(drawn)}
    known = {name: field for name, field in found.items() if field is not None}
    if len(known) == 2 and len({f.shape for f in known.values()}) == 1:
        measured, model = known.values()
        known["residual"] = measured - model
    top = max((float(np.nanpercentile(np.abs(f), 99)) for f in known.values()), default=0.0)
    return known, top or 1.0


def maps(drawn: Sequence[Layer], most: int = 2) -> list[Picture | None]:
    """Measured, model and residual in a row with one colour bar, a picture an operating point."""
    measured = drawn[0].statistics
    settings = chosen(measured, most, lambda s: _map(s) is not None)
    named = zip(settings, labels(settings), strict=True)
    return [
        _row(drawn, s, title, plane_note(measured, settings) if s is settings[-1] else "")
        for s, title in named
    ]


def _row(
    drawn: Sequence[Layer], setting: SettingStatistics, title: str, note: str
) -> Picture | None:
    found, limit = fields(drawn, setting)

    def cell(name: str, field: np.ndarray) -> Cell:
        wide = min(2.6, max(1.2, 2.0 * (field.shape[1] / field.shape[0]) ** 0.5))
        tall = wide * field.shape[0] / field.shape[1] + 0.3
        return Cell(lambda ax: draw_shading(ax, field, limit), wide, tall, title=name)

    cells = [cell(name, field) for name, field in found.items()]
    return panels(
        [*cells, bar_cell(BAR, -limit, limit, COLOURS, max((c.height for c in cells), default=2))],
        "Mean of each block of pixels minus the mean of the frame; hot pixels are clipped at six "
        "robust standard deviations. All maps of a row have the same colours." + note
        if note or not title
        else "",
        f"Maps of the block means at {title}: " + ", ".join(found),
        title=title,
    )


def _map(setting: SettingStatistics | None) -> np.ndarray | None:
    found = curve(setting, "block_means")
    if found is None or found[0].ndim != 2:
        return None
    return np.asarray(found[0] - np.nanmean(found[0]))
