"""A learned pattern: its map, and its size at every operating point."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.report.figures.shading import draw_shading
from dnanalyze.report.figures.style import INK, Cell, Picture, panels

MAX_MAP_SIDE = 192  # rows and columns of the map that are drawn


def learned_pattern(result: Any) -> Picture | None:
    """Map and sizes; None where no pattern was learned."""
    field = result.effect.map.array
    if not field.any():
        return None
    small = _small(field)
    limit = float(np.percentile(np.abs(small), 99.5)) or 1.0

    def draw_map(ax: Any) -> None:
        draw_shading(ax, small, limit).set_title("pattern [DN]")

    def draw_sizes(ax: Any) -> None:
        warm = [p.temperature_c for p in result.points]
        known = None not in warm and len(set(warm)) > 1
        x = np.array(warm if known else range(1, len(warm) + 1), float)
        told = np.isfinite(result.errors)
        ax.errorbar(x[told], result.sizes[told], yerr=result.errors[told], fmt="o", color=INK,
                    markersize=4)  # fmt: skip
        ax.set_xlabel("temperature [°C]" if known else "operating point")
        ax.set_ylabel("size / size at the reference")

    tall = min(3.4, max(1.2, 2.6 * small.shape[0] / small.shape[1]))
    return panels(
        [Cell(draw_map, 2.7, tall + 0.3), Cell(draw_sizes)],
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
