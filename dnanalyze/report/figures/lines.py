"""Column and row means of the fixed pattern, and their spectra."""

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
    log_axis,
    name_layers,
    picture,
    plane_note,
    thinned,
)

SIDES = ("column", "row")


def profiles(drawn: Sequence[Layer]) -> Picture | None:
    """Line means along the sensor for the coldest and the warmest setting, spectra beside them."""
    measured = drawn[0].statistics
    settings = chosen(measured, 2)
    if not any(curve(s, f"{side}_mean") for s in settings for side in SIDES):
        return None
    named = list(zip(settings, labels(settings), strict=True))
    rows = [(side, s, t) for side in SIDES for s, t in named if curve(s, f"{side}_mean")]

    def draw() -> Any:
        fig, axes = figure(
            len(rows), 3, 0.5 + 1.55 * len(rows), gridspec_kw={"width_ratios": (2.2, 1, 1)}
        )
        for (side, setting, title), (line, fixed, temporal) in zip(rows, axes, strict=True):
            for layer in drawn:
                own = layer.like(setting)
                found = curve(own, f"{side}_mean")
                style = {
                    "color": layer.colour,
                    "linestyle": layer.dash,
                    "linewidth": 0.85 * layer.width,
                }
                if found is not None and layer.label != "Gaussian":
                    y = found[0] - np.nanmean(found[0])
                    line.plot(*thinned(np.arange(len(y), dtype=float), y, 900), **style)
                for ax, part in ((fixed, "pattern"), (temporal, "temporal")):
                    spectrum = curve(own, f"{part}_{side}_spectrum")
                    if spectrum is not None:
                        ax.plot(*_spectrum(spectrum[0]), **style)
            line.set_title(f"{side} means of the fixed pattern, {title}")
            line.set_ylabel("DN")
            line.margins(x=0.01)
            for ax, part in ((fixed, "their spectrum, fixed"), (temporal, "temporal")):
                ax.set_title(part)
                if ax.lines:
                    ax.set_xscale("log")
                    ax.set_yscale("log")
                    log_axis(ax.xaxis)
                    log_axis(ax.yaxis)
                else:
                    ax.set_axis_off()
                    ax.text(0, 0.5, "not told by these frames", transform=ax.transAxes, fontsize=8)
            fixed.set_ylabel("DN²")
        axes[-1, 0].set_xlabel("position [pixels]")
        for ax in axes[-1, 1:]:
            ax.set_xlabel("cycles/pixel")
        name_layers(fig, drawn)
        return fig

    return picture(
        draw,
        "Means of columns and rows, and the power spectrum of those means in units of a pixel's "
        "variance: lines that carry nothing of their own lie at the level of the pixels."
        + plane_note(measured),
        "Column and row means of the fixed pattern with their spectra.",
    )


def _spectrum(power: np.ndarray, most: int = 30) -> tuple[np.ndarray, np.ndarray]:
    """Frequency and power, pooled into steps of equal ratio; the mean itself is left out."""
    f = np.linspace(0, 0.5, len(power))[1:]
    s = power[1:]
    edges = np.unique(np.searchsorted(f, np.geomspace(f[0], f[-1] * 1.0001, most)))
    counts = np.diff(np.append(edges, len(f)))
    keep = counts > 0
    edges, counts = edges[keep], counts[keep]
    return np.add.reduceat(f, edges) / counts, np.add.reduceat(s, edges) / counts
