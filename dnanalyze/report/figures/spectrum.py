"""Radial power spectra of DSNU and temporal dark noise."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics
from dnanalyze.report.figures.style import (
    INK,
    QUIET,
    Cell,
    Layer,
    Picture,
    chosen,
    curve,
    frequency_axis,
    has,
    labels,
    log_axis,
    main_run,
    panels,
    plane_note,
)

FEWEST_MODES = 12  # in a drawn point: power scatters as 1 / sqrt(modes)
PARTS = {"pattern": "DSNU", "temporal": "temporal noise", "frame": "single frame"}
FULL = "measured, with whole rows and columns"


def draw_spectrum(
    ax: Any,
    drawn: Sequence[Layer],
    setting: SettingStatistics,
    part: str = "pattern",
    whole: bool = False,
) -> Any:
    """Radial power spectrum off the axes, up to the corner of the frequency plane.

    Parameters
    ----------
    part : str
        "pattern" (DSNU), "temporal" (temporal dark noise) or "frame" (a single frame).
    whole : bool
        With the axes, where whole rows and columns show; without them those of the measured are a
        thin grey line.
    """
    names = names_of(part, whole)
    if curve(setting, *names) is None:
        return ax
    repeats = max(1, setting.frames - 1) if part == "temporal" else 1
    for layer in drawn:
        found = curve(layer.like(setting), *names)
        if found is None:
            continue
        f, s, modes = pooled(found, setting)
        ax.plot(f, s, **layer.line)
        if layer.band:
            spread = np.exp(2 / np.sqrt(modes * repeats))
            ax.fill_between(f, s / spread, s * spread, color=INK, alpha=0.15, lw=0)
    full = curve(setting, *names_of(part, True))
    if full is not None and not whole:
        f, s, _ = pooled(full, setting)
        ax.plot(f, s, color=QUIET, linewidth=0.7, zorder=1.5, label=FULL)
    ax.set_yscale("log")
    log_axis(ax.yaxis)
    frequency_axis(ax, "radial frequency [cycles/pixel]")
    ax.set_ylabel(f"power of the {PARTS[part]} [DN²]")
    return ax


def spectra(drawn: Sequence[Layer], most: int = 3) -> Picture | None:
    """Rows of panels are the parts that the frames can tell."""
    measured = drawn[0].statistics
    some = [p for p in PARTS if main_run(measured, has(*names_of(p)))]
    if "temporal" in some and "frame" in some:
        some.remove("frame")

    cells, shown = [], []
    for part in some:
        shown = chosen(measured, most, has(*names_of(part)))
        cells += [
            Cell(
                partial(draw_spectrum, drawn=drawn, setting=s, part=part),
                title=f"{PARTS[part]}, {t}",
            )
            for s, t in zip(shown, labels(shown), strict=True)
        ]
    return panels(
        cells,
        "Power spectra over the radial frequency, normalised so that white noise of variance s² "
        "has the power s². The frequencies of whole rows and columns are left out, except in the "
        "thin grey line. Band: two standard errors. The Nyquist frequency of rows and columns is "
        "0.5 cycles/pixel; the diagonal reaches 0.71." + plane_note(measured, shown),
        "Radial power spectra of " + " and ".join(PARTS[p] for p in some),
    )


def names_of(part: str, whole: bool = False) -> tuple[str, str]:
    """Curves of the radial spectrum of a part: frequency, power (with whole rows and columns)."""
    return f"{part}_radial_f", f"{part}_radial_{'full_' if whole else ''}s"


def pooled(
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
