"""A described structure: residual map, profile along its geometry, size over temperature."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.report.figures.shading import COLOURS, draw_shading
from dnanalyze.report.figures.style import INK, MODEL, Cell, Picture, panels


def draw_profile(ax: Any, look: Any) -> Any:
    """Mean of the map along the geometry."""
    ax.plot(look.x, look.y, color=INK, linewidth=1.2)
    ax.set(xlabel=look.along, ylabel=look.title.split("[")[-1].join(("[", "")) or "DN")
    return ax


def draw_law(ax: Any, look: Any) -> Any:
    """Size at every operating point with its standard error, and by the law."""
    warm = [p.temperature_c for p in look.points]
    known = None not in warm and len(set(warm)) > 1
    x = np.array(warm if known else range(1, len(warm) + 1), float)
    order = np.argsort(x, kind="stable")
    ax.errorbar(x, look.sizes, yerr=look.errors, fmt="o", color=INK, markersize=4)
    ax.plot(x[order], look.fitted[order], color=MODEL)
    ax.set_xlabel("temperature [°C]" if known else "operating point")
    ax.set_ylabel("size [DN]")
    ax.set_ylim(bottom=0.0)
    return ax


def description(look: Any) -> Picture | None:
    """The three panels; None where nothing was found."""
    if look is None:
        return None
    limit = float(np.percentile(np.abs(look.map), 99.5)) or 1.0

    def draw_map(ax: Any) -> None:
        draw_shading(ax, look.map, limit).set_title(look.title)

    tall = min(3.4, max(1.2, 2.6 * look.map.shape[0] / look.map.shape[1]))
    return panels(
        [
            Cell(draw_map, 2.7, tall + 0.3),
            Cell(lambda ax: draw_profile(ax, look)),
            Cell(lambda ax: draw_law(ax, look)),
        ],
        f"Residual map ({look.title}; red: +{limit:.3g}, blue: −{limit:.3g}), its mean along the "
        "geometry found, and the size at every operating point (dots: measured; line: law).",
        "Map of the residual, profile along the structure, size over the operating points.",
    )


__all__ = ["COLOURS", "description", "draw_law", "draw_profile"]
