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
    labels,
    log_axis,
    name_layers,
    picture,
    plane_note,
)

FEWEST_MODES = 12  # in a drawn point: power scatters as 1 / sqrt(modes)
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
        for ax, title in zip(axes[0], labels(settings), strict=True):
            ax.set_title(title)
        for ax in axes[-1]:
            log_axis(ax.xaxis)
            ax.set_xlabel("cycles/pixel")
        name_layers(fig, drawn)
        return fig

    return picture(
        draw,
        "Power spectra over radial frequency, normalised so that white noise of variance s² is "
        "at s². The axes are masked: what rows and columns add is left out (their own panel "
        "shows it). Band: two standard errors. Thin grey line: the full spectrum with the axes."
        + plane_note(measured),
        "Radial power spectra of " + " and ".join(PARTS[p] for p in parts),
    )


def _names(part: str) -> tuple[str, str]:
    return f"{part}_radial_f", f"{part}_radial_s"


def _panel(ax: Any, setting: SettingStatistics, drawn: Sequence[Layer], part: str) -> None:
    full = curve(setting, f"{part}_radial_f", f"{part}_radial_full_s")
    if full is not None:
        f, s, _ = _pooled(full, setting)
        ax.plot(f, s, color=QUIET, linewidth=0.7)
    repeats = max(1, setting.frames - 1) if part == "temporal" else 1
    for layer in drawn:
        found = curve(layer.like(setting), *_names(part))
        if found is None:
            continue
        f, s, modes = _pooled(found, setting)
        ax.plot(f, s, color=layer.colour, linestyle=layer.dash, linewidth=layer.width)
        if layer.band:
            spread = np.exp(2 / np.sqrt(modes * repeats))
            ax.fill_between(f, s / spread, s * spread, color=INK, alpha=0.15, lw=0)
    ax.set_xscale("log")
    ax.set_yscale("log")


def _pooled(
    found: tuple[np.ndarray, ...], setting: SettingStatistics, most: int = 70
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rings pooled into steps of nearly equal ratio with enough modes each: f, power, modes.

    A ring of radius f and width df holds pi f df rows columns independent modes.
    """
    f, s = found
    keep = (f > 0) & np.isfinite(s) & (s > 0)
    f, s = f[keep], s[keep]
    if len(f) < 2:
        return f, s, np.ones_like(f)
    modes = np.pi * f * np.gradient(f) * setting.shape[0] * setting.shape[1]
    ratio = (f[-1] / f[0]) ** (1.0 / most)
    slots, begun, held = np.zeros(len(f), int), f[0], 0.0
    for i in range(1, len(f)):
        held += modes[i - 1]
        fresh = held >= FEWEST_MODES and f[i] >= begun * ratio
        slots[i] = slots[i - 1] + fresh
        if fresh:
            begun, held = f[i], 0.0
    total = np.bincount(slots, modes)
    return np.bincount(slots, f * modes) / total, np.bincount(slots, s * modes) / total, total
