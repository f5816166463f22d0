"""Radial power spectra of pattern and temporal noise, one column an operating point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.report.figures.style import (
    INK,
    QUIET,
    Layer,
    Picture,
    chosen,
    curve,
    figure,
    log_axis,
    name_layers,
    picture,
    plane_note,
)

PARTS = {"pattern": "fixed pattern", "temporal": "temporal noise", "frame": "single frames"}


def spectra(drawn: Sequence[Layer], most: int = 5) -> Picture | None:
    """Axis-masked radial spectra; rows of panels are the parts that the frames can tell."""
    measured = drawn[0].statistics
    settings = chosen(measured, most)
    parts = [p for p in PARTS if any(curve(s, *_names(p)) for s in settings)]
    if "temporal" in parts and "frame" in parts:
        parts.remove("frame")
    if not parts:
        return None

    def draw() -> Any:
        fig, axes = figure(
            len(parts), len(settings), 0.4 + 2.05 * len(parts), sharex=True, sharey="row"
        )
        for row, part in zip(axes, parts, strict=True):
            for ax, setting in zip(row, settings, strict=True):
                _panel(ax, setting, drawn, part)
            row[0].set_ylabel(f"{PARTS[part]}\n[DN²]")
            log_axis(row[0].yaxis)
        for ax, setting in zip(axes[0], settings, strict=True):
            ax.set_title(setting.point.label())
        for ax in axes[-1]:
            log_axis(ax.xaxis)
            ax.set_xlabel("cycles/pixel")
        name_layers(fig, drawn)
        return fig

    return picture(
        draw,
        "Power spectra over radial frequency, normalised so that white noise of variance s² is "
        "at s². The axes are masked, so that what rows and columns add is left out (their own panel "
        "shows it). Band: two standard errors. Thin grey line: the full spectrum with the axes."
        + plane_note(measured),
        "Radial power spectra of " + " and ".join(PARTS[p] for p in parts),
    )


def _names(part: str) -> tuple[str, str]:
    return f"{part}_radial_f", f"{part}_radial_s"


def _panel(ax: Any, setting: SettingStatistics, drawn: Sequence[Layer], part: str) -> None:
    full = curve(setting, f"{part}_radial_f", f"{part}_radial_full_s")
    if full is not None:
        f, s = _sparse(*full)[:2]
        ax.plot(f, s, color=QUIET, linewidth=0.7)
    for layer in drawn:
        found = curve(layer.like(setting), *_names(part))
        if found is None:
            continue
        f, s, members = _sparse(*found)
        ax.plot(f, s, color=layer.colour, linestyle=layer.dash, linewidth=layer.width)
        if layer.band:
            spread = 2 * s / np.sqrt(_modes(f, members, setting, part))
            low = np.maximum(s - spread, s * 0.02)
            ax.fill_between(f, low, s + spread, color=INK, alpha=0.15, lw=0)
    ax.set_xscale("log")
    ax.set_yscale("log")


def _sparse(f: np.ndarray, s: np.ndarray, most: int = 90) -> tuple[np.ndarray, ...]:
    """Rings pooled into steps of equal ratio: frequency, power, and the pooled width."""
    keep = (f > 0) & np.isfinite(s) & (s > 0)
    f, s = f[keep], s[keep]
    if len(f) < 2:
        return f, s, np.ones_like(f)
    step = float(np.median(np.diff(f)))
    edges = np.geomspace(f[0] * 0.999, f[-1] * 1.001, most + 1)
    slot = np.searchsorted(edges, f) - 1
    weight = np.bincount(slot, f, most)  # a ring holds modes in proportion to its radius
    full = weight > 0
    power = np.bincount(slot, s * f, most)[full] / weight[full]
    radius = np.bincount(slot, f * f, most)[full] / weight[full]
    return radius, power, np.bincount(slot, minlength=most)[full] * step


def _modes(f: np.ndarray, width: np.ndarray, setting: SettingStatistics, part: str) -> np.ndarray:
    """Independent modes of a ring: half of 2 pi f df rows columns, for each independent repeat."""
    pixels = setting.shape[0] * setting.shape[1]
    repeats = {"temporal": max(1, setting.frames - 1)}.get(part, 1)
    return np.maximum(np.pi * f * width * pixels * repeats, 1.0)
