"""A learned pattern: its map, and its size at every operating point."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.description.pattern import LearnedPattern
from dnanalyze.report.figures.description import draw_sizes, map_cell
from dnanalyze.report.figures.style import Cell, Picture, panels

MAX_MAP_SIDE = 192  # rows and columns of the map that are drawn


def learned_pattern(result: LearnedPattern) -> Picture | None:
    """Map and sizes; None where no pattern was learned."""
    field = result.effect.map.array
    if not field.any():
        return None
    small = _small(field)
    limit = float(np.percentile(np.abs(small), 99.5)) or 1.0

    def draw(ax: Any) -> None:
        draw_sizes(ax, result)
        ax.set_ylabel("size / size at the reference")

    return panels(
        [map_cell(small, limit, "pattern [DN]"), Cell(draw)],
        f"Learned pattern at the reference operating point (red: +{limit:.3g} DN, blue: "
        f"−{limit:.3g} DN), and its size at every operating point.",
        "Map of the learned pattern, and its size over the operating points.",
    )


def _small(field: np.ndarray) -> np.ndarray:
    """Means of blocks, so that a screen shows all of it."""
    step = max(1, -(-max(field.shape) // MAX_MAP_SIDE))
    rows, columns = (n // step for n in field.shape)
    cut = field[: rows * step, : columns * step].reshape(rows, step, columns, step)
    return np.asarray(cut.mean(axis=(1, 3)))
