"""The two-dimensional spectra: a direction shows as a line, a frequency as a spot."""

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

PARTS = {"pattern": "fixed pattern", "temporal": "temporal noise"}
DARKEST, BRIGHTEST = -8.0, 14.0  # dB about the median that the colours span


def planes(drawn: Sequence[Layer]) -> Picture | None:
    """Power over (u, v) in dB about its median, for the coldest and the warmest setting."""
    measured = drawn[0].statistics
    settings = chosen(measured, 2)
    shown = [k for k in drawn if k.label != "Gaussian"]
    cells = [
        (part, setting, title)
        for part in PARTS
        for setting, title in zip(settings, labels(settings), strict=True)
        if _plane(setting, part) is not None
    ]
    if not cells:
        return None

    def draw() -> Any:
        fig, axes = figure(len(shown), len(cells), 0.5 + 2.1 * len(shown))
        image = None
        for place, (row, layer) in enumerate(zip(axes, shown, strict=True)):
            for ax, (part, setting, title) in zip(row, cells, strict=True):
                ax.grid(False)
                own = layer.like(setting)
                power = _plane(own, part) if own is not None else None
                if power is None:
                    ax.set_axis_off()
                    continue
                image = ax.imshow(
                    power, vmin=DARKEST, vmax=BRIGHTEST, aspect="auto", origin="lower",
                    extent=(-0.5, 0.5, -0.5, 0.5), interpolation="nearest",
                )  # fmt: skip
                ax.set_xticks([-0.5, 0, 0.5])
                ax.set_yticks([-0.5, 0, 0.5])
                if place == 0:
                    ax.set_title(f"{PARTS[part]}, {title}")
                if place == len(shown) - 1:
                    ax.set_xlabel("u [cycles/pixel]")
            row[0].set_ylabel(f"{layer.label}\nv [cycles/pixel]")
        bar = fig.colorbar(image, ax=axes, shrink=0.7, aspect=26, pad=0.01)
        bar.set_label("dB about the median")
        bar.outline.set_visible(False)
        return fig

    return picture(
        draw,
        "Power over horizontal (u) and vertical (v) frequency. Column structure is a bright "
        "horizontal line, row structure a vertical one, interference a pair of spots, smoothing a "
        "darkening outwards." + plane_note(measured),
        "Two-dimensional power spectra.",
    )


def _plane(setting: Any, part: str) -> np.ndarray | None:
    """The plane in dB about its median; the left half is the right one turned by 180 degrees."""
    found = curve(setting, f"{part}_psd2d")
    if found is None or found[0].ndim != 2:
        return None
    right = 10 * (found[0] - np.median(found[0]))
    left = np.roll(right[::-1, ::-1], 1, axis=0)  # the first row is v = -1/2, its own mirror
    return np.hstack([left, right])
