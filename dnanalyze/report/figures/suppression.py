"""The paper's figure 2: high-frequency power over mid-frequency power against temperature."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from dnanalyze.report.figures.style import (
    GAUSSIAN,
    INK,
    MODEL,
    QUIET,
    Layer,
    Picture,
    figure,
    picture,
    plane_note,
)
from dnanalyze.report.words import is_number

CROSSTALK = (0.005, 0.01, 0.02)  # weight of each of the 8 neighbours
HIGH, MIDDLE = (0.45, 0.72), (0.03, 0.12)  # cycles/pixel


def suppression(measured: Layer) -> Picture | None:
    """HF/MF of single frames and of their temporal part, with what crosstalk alone would give."""
    statistics = measured.statistics
    plane = statistics.settings[0].plane if statistics.settings else ""
    own = [s for s in statistics.settings if s.plane == plane and "frame_hf_mf" in s.values]
    own = [s for s in own if is_number(s.point.temperature_c)]
    if not own:
        return None
    celsius = np.array([s.point.temperature_c for s in own], float)

    def draw() -> Any:
        fig, axes = figure(1, 1, 3.3)
        ax = axes[0, 0]
        ax.plot([celsius.min(), celsius.max()], [1, 1], color=QUIET, linewidth=1.0)
        ax.annotate(
            "unfiltered", (celsius.max(), 1), (6, 0), textcoords="offset points", va="center",
            color=QUIET, annotation_clip=False,
        )  # fmt: skip
        if len(set(celsius)) > 1:
            for phi in CROSSTALK:
                _crosstalk(ax, own, celsius, phi)
        for name, label, colour in (
            ("frame_hf_mf", "single frames", INK),
            ("temporal_hf_mf", "temporal noise", MODEL),
        ):
            values = [s.values.get(name) for s in own]
            y = np.array([v.value if v else np.nan for v in values], float)
            spread = np.array([2 * v.se if v else np.nan for v in values], float)
            low, high = y * np.exp(-spread), y * np.exp(spread)
            if np.isfinite(y).any():
                ax.vlines(celsius, low, high, color=colour, alpha=0.35, linewidth=3.2)
                ax.plot(celsius, y, "o-", color=colour, markersize=4, label=label)
        ax.set_ylim(0, max(1.25, ax.get_ylim()[1]))
        ax.set_xlabel("°C")
        ax.set_ylabel("high over mid-frequency power")
        ax.legend(loc="lower left")
        return fig

    return picture(
        draw,
        "Power above .45 cycles/pixel over power from .03 to .12, axes masked, over temperature. "
        "An unfiltered sensor stays at 1. Defect correction pulls it down when warm; denoise, "
        "often, when cold. Linear crosstalk falls, then levels off: the dashed curves are what "
        "crosstalk of the stated weight a neighbour would give. Bars: two standard errors."
        + plane_note(statistics),
        "High-frequency suppression over temperature.",
    )


def transfer(phi: float, band: tuple[float, float], size: int = 128) -> float:
    """Mean of |K|^2 over a band of radial frequency; K = (1-9 phi) + phi (1+2cos)(1+2cos)."""
    f = np.fft.fftfreq(size)
    u, v = np.meshgrid(f, f)
    k = 1 - 9 * phi + phi * (1 + 2 * np.cos(2 * np.pi * u)) * (1 + 2 * np.cos(2 * np.pi * v))
    radius = np.hypot(u, v)
    inside = (radius > band[0]) & (radius < band[1])
    return float(np.mean(k[inside] ** 2))


def _crosstalk(ax: Any, settings: Sequence[Any], celsius: np.ndarray, phi: float) -> None:
    """(s_r^2 + P |K|^2_high) / (s_r^2 + P |K|^2_mid): s_r^2 the coldest power, P what heat adds."""
    power = np.array([s.values["frame_psd_0.08_0.16"].value for s in settings], float)
    order = np.argsort(celsius)
    read = power[order[0]]
    added = np.maximum(power - read, 0)
    high, middle = transfer(phi, HIGH), transfer(phi, MIDDLE)
    r = ((read + added * high) / (read + added * middle))[order]
    ax.plot(celsius[order], r, color=GAUSSIAN, linewidth=0.9, linestyle=(0, (4, 2)))
    ax.annotate(
        f"crosstalk {100 * phi:g} %", (celsius[order[-1]], r[-1]), (6, 0), va="center",
        textcoords="offset points", color=GAUSSIAN, fontsize=7.2, annotation_clip=False,
    )  # fmt: skip
