"""How the fitted parameters hang together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.report.figures.style import Cell, Picture, panels


def draw_correlations(ax: Any, names: Sequence[str], matrix: Any) -> Any:
    """Correlation matrix of the parameters that are determined."""
    shown, square = _determined(names, matrix)
    if len(shown) < 2:
        return ax
    ax.grid(visible=False)
    image = ax.imshow(square, cmap="RdBu_r", vmin=-1, vmax=1)
    ax.set_yticks(range(len(shown)), shown)
    ax.set_xticks(range(len(shown)), shown, rotation=90)
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)
    bar = ax.figure.colorbar(image, ax=ax, shrink=0.6, aspect=22, pad=0.02)
    bar.set_label("correlation coefficient")
    bar.outline.set_visible(False)
    return ax


def _determined(names: Sequence[str], matrix: Any) -> tuple[list[str], np.ndarray]:
    square = np.asarray(matrix, float)
    if square.shape != (len(names), len(names)):
        return [], np.empty((0, 0))
    keep = np.flatnonzero(np.isfinite(np.diag(square)))
    return [names[int(n)] for n in keep], square[np.ix_(keep, keep)]


def correlations(names: Sequence[str], matrix: Any) -> Picture | None:
    """The matrix as a picture."""
    shown, _ = _determined(names, matrix)
    side = min(6.0, 2.4 + 0.2 * len(shown))
    return panels(
        [Cell(lambda ax: draw_correlations(ax, names, matrix), side + 1.4, side)],
        "Correlation of the estimates of the parameters. Near +1 or −1 the captures determine "
        "only a combination of the two.",
        "Correlation matrix of the fitted parameters.",
    )
