"""A described structure: residual map, profile along its geometry, size over temperature."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.description.look import Look
from dnanalyze.description.pattern import LearnedPattern
from dnanalyze.report.figures.shading import draw_shading
from dnanalyze.report.figures.style import INK, MODEL, Cell, Picture, panels


def draw_profile(ax: Any, look: Look) -> Any:
    """Mean of the map along the geometry."""
    ax.plot(look.x, look.y, color=INK, linewidth=1.2)
    ax.set(xlabel=look.along, ylabel=look.title.split("[")[-1].join(("[", "")) or "DN")
    return ax


def draw_law(ax: Any, look: Look) -> Any:
    """Size at every operating point with its standard error, and by the law."""
    x = draw_sizes(ax, look)
    order = np.argsort(x, kind="stable")
    ax.plot(x[order], look.fitted[order], color=MODEL)
    ax.set_ylabel("size [DN]")
    ax.set_ylim(bottom=0.0)
    return ax


def draw_sizes(ax: Any, found: Look | LearnedPattern) -> np.ndarray:
    """Sizes at the operating points with their standard errors, and where they were drawn."""
    warm = [p.temperature_c for p in found.points]
    known = None not in warm and len(set(warm)) > 1
    x = np.array(warm if known else range(1, len(warm) + 1), float)
    told = np.isfinite(found.errors)
    ax.errorbar(
        x[told], found.sizes[told], yerr=found.errors[told], fmt="o", color=INK, markersize=4
    )  # fmt: skip
    ax.set_xlabel("temperature [°C]" if known else "operating point")
    return x


def map_cell(field: np.ndarray, limit: float, title: str) -> Cell:
    """A map whose colours run from minus to plus ``limit``, as a panel."""
    tall = min(3.4, max(1.2, 2.6 * field.shape[0] / field.shape[1]))
    return Cell(lambda ax: draw_shading(ax, field, limit), 2.7, tall + 0.3, title=title)


def description(look: Look | None) -> Picture | None:
    """The three panels; None where nothing was found."""
    if look is None:
        return None
    limit = float(np.percentile(np.abs(look.map), 99.5)) or 1.0
    return panels(
        [
            map_cell(look.map, limit, look.title),
            Cell(lambda ax: draw_profile(ax, look)),
            Cell(lambda ax: draw_law(ax, look)),
        ],
        f"Residual map ({look.title}; red: +{limit:.3g}, blue: −{limit:.3g}), its mean along the "
        "geometry found, and the size at every operating point (dots: measured; line: law).",
        "Map of the residual, profile along the structure, size over the operating points.",
    )
