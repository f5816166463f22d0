"""The patches that a classifier tells best: measured beside simulated."""

from __future__ import annotations

import numpy as np

from dnanalyze.classifier.result import Classification
from dnanalyze.report.figures.colour_bar import bar_cell
from dnanalyze.report.figures.shading import COLOURS, draw_shading
from dnanalyze.report.figures.style import Cell, Picture, panels

GAP = 2  # pixels between patches


def classifier_patches(result: Classification) -> Picture | None:
    """Patches of the operating point and kind of picture that tell most; None without any."""
    told = result.patches
    if told is None:
        return None
    both = np.concatenate((told.measured, told.simulated))
    limit = float(np.percentile(np.abs(both), 99.5)) or 1.0
    rows, columns = told.measured.shape[1:]
    across = max(1, round((len(told.measured) * rows / columns) ** 0.5))

    def cell(name: str, patches: np.ndarray) -> Cell:
        field = _mosaic(patches, min(across, len(patches)))
        wide = float(np.clip(2.6 * (field.shape[1] / field.shape[0]) ** 0.5, 1.2, 3.4))
        tall = min(3.6, wide * field.shape[0] / field.shape[1]) + 0.3
        return Cell(lambda ax: draw_shading(ax, field, limit), wide, tall, title=name)

    cells = [cell("measured", told.measured), cell("simulated", told.simulated)]
    height = max(c.height for c in cells)
    at = told.point.label()
    return panels(
        [*cells, bar_cell("value − level [DN]", -limit, limit, COLOURS, height)],
        f"Patches of the {told.picture} at {at} for which the classifier is most certain: measured "
        "ones that look least like the simulation, simulated ones that look least like the sensor. "
        "Each is a place of its own; the level of the frame is subtracted.",
        f"Measured and simulated patches of the {told.picture} at {at}.",
    )


def _mosaic(patches: np.ndarray, across: int) -> np.ndarray:
    """Patches side by side with gaps that stay empty."""
    count, rows, columns = patches.shape
    down = -(-count // across)
    field = np.full((down * (rows + GAP) - GAP, across * (columns + GAP) - GAP), np.nan)
    for n, patch in enumerate(patches):
        top, left = (n // across) * (rows + GAP), (n % across) * (columns + GAP)
        field[top : top + rows, left : left + columns] = patch
    return field
