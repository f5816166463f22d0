"""How the fitted parameters hang together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.report.figures.style import Picture, figure, picture


def correlations(names: Sequence[str], matrix: Any) -> Picture | None:
    """Correlation matrix of the parameters that are determined."""
    square = np.asarray(matrix, float)
    if square.shape != (len(names), len(names)):
        return None
    keep = np.flatnonzero(np.isfinite(np.diag(square)))
    if len(keep) < 2:
        return None
    square = square[np.ix_(keep, keep)]

    def draw() -> Any:
        side = min(8.0, 2.6 + 0.24 * len(keep))
        fig, axes = figure(1, 1, side, width=side + 1.6)
        ax = axes[0, 0]
        ax.grid(False)
        image = ax.imshow(square, cmap="RdBu_r", vmin=-1, vmax=1)
        shown = [names[int(i)] for i in keep]
        ax.set_yticks(range(len(keep)), shown)
        ax.set_xticks(range(len(keep)), shown, rotation=90)
        ax.tick_params(length=0)
        for spine in ax.spines.values():
            spine.set_visible(False)
        bar = fig.colorbar(image, ax=ax, shrink=0.6, aspect=22, pad=0.02)
        bar.set_label("correlation")
        bar.outline.set_visible(False)
        return fig

    return picture(
        draw,
        "Correlations of the parameters: near +1 or -1 only a combination of the two is known.",
        "Correlation matrix of the fitted parameters.",
    )
