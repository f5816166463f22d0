"""The slow shape of the field: block means, measured beside the model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.report.figures.style import (
    Layer,
    Picture,
    chosen,
    curve,
    figure,
    labels,
    picture,
    plane_note,
)


def maps(drawn: Sequence[Layer], most: int = 5) -> Picture | None:
    """Block means minus their mean; rows are the layers, columns the operating points."""
    measured = drawn[0].statistics
    settings = [s for s in chosen(measured, most) if _map(s) is not None]
    if not settings:
        return None

    def draw() -> Any:
        height = 0.35 + 1.75 * len(drawn)
        fig, axes = figure(len(drawn), len(settings), height)
        for place, setting in enumerate(settings):
            fields = [_map(layer.like(setting)) for layer in drawn]
            known = [f for f in fields if f is not None]
            top = max(float(np.nanpercentile(np.abs(f), 99)) for f in known) or 1.0
            image = None
            for ax, field in zip(axes[:, place], fields, strict=True):
                ax.grid(False)
                ax.set_xticks([])
                ax.set_yticks([])
                if field is None:
                    ax.set_axis_off()
                    continue
                image = ax.imshow(field, cmap="RdBu_r", vmin=-top, vmax=top, aspect="equal")
                for spine in ax.spines.values():
                    spine.set_visible(False)
            bar = fig.colorbar(image, ax=list(axes[:, place]), shrink=0.6, aspect=24, pad=0.02)
            bar.outline.set_visible(False)
            bar.ax.tick_params(labelsize=7, length=2)
            axes[0, place].set_title(labels(settings)[place])
        for row, layer in zip(axes, drawn, strict=True):
            row[0].set_ylabel(layer.label)
        return fig

    return picture(
        draw,
        "Block means of the fixed pattern minus their mean, DN; one colour scale a column. "
        "Hot pixels are cut off at six robust sigmas." + plane_note(measured),
        "Maps of the block means for " + ", ".join(k.label for k in drawn),
    )


def _map(setting: Any) -> np.ndarray | None:
    found = curve(setting, "block_means")
    if found is None or found[0].ndim != 2:
        return None
    return found[0] - np.nanmean(found[0])
