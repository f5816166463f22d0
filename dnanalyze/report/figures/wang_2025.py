"""Figures 1 and 2 of Wang et al. (2025) for the user's own sensor.

Figure 1: histogram on a log scale and radial spectra, measured and of models, on one axis.
Figure 2: spectra of all temperatures on one axis.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Statistics
from dnanalyze.report.figures.distribution import draw_histogram
from dnanalyze.report.figures.spectrum import PARTS, draw_spectrum, names_of, pooled
from dnanalyze.report.figures.style import (
    INK,
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
from dnanalyze.report.words import point_label

MAX_POINTS = 8  # operating points in one figure
# from cold to hot, of one lightness, so that they show on light and on dark paper
WARMTH = ["#2f7fd6", "#7d6bd8", "#c0519f", "#dd5a5a", "#e08a1e"]
DASHES = "-", (0, (4, 1.6))  # measured, model


def parts_of(measured: Statistics) -> list[str]:
    """The parts whose spectra the frames can tell: DSNU and temporal noise, else a single frame."""
    some = [p for p in PARTS if main_run(measured, has(*names_of(p, True)))]
    return [p for p in some if p != "frame"] if "pattern" in some else some


def figure_1(drawn: Sequence[Layer], setting: SettingStatistics) -> Picture | None:
    """Histogram and radial spectra of one operating point, every layer on one axis.

    Parameters
    ----------
    drawn : sequence of Layer
        The measured first.
    setting : SettingStatistics
        Of the measured.
    """

    drawings: dict[str, Callable[[Any], Any]] = {
        "histogram, all pixels and frames": partial(draw_histogram, drawn=drawn, setting=setting)
    } | {
        f"radial spectrum, {PARTS[part]}": partial(
            draw_spectrum, drawn=drawn, setting=setting, part=part, whole=True
        )
        for part in parts_of(drawn[0].statistics)
    }
    return panels(
        [Cell(draw, 3.35, 2.7, title=title) for title, draw in drawings.items()],
        f"At {point_label(setting.point)}. Bands: two standard errors. White noise of variance s² "
        "has a flat spectrum of power s².",
        f"Histogram and radial power spectra: {', '.join(k.label for k in drawn)}.",
    )


def draw_spectra_over(
    ax: Any, drawn: Sequence[Layer], settings: Sequence[SettingStatistics], part: str
) -> Any:
    """Radial spectra of several operating points on one axis, a colour each.

    The first layer is solid, the others are dashed.
    """
    from matplotlib.colors import LinearSegmentedColormap

    warmth = LinearSegmentedColormap.from_list("warmth", WARMTH)
    tones = warmth(np.linspace(0, 1, max(len(settings), 2)))
    looks = list(zip(drawn, DASHES, strict=False))
    for place, (layer, dash) in enumerate(looks):
        for tone, setting, title in zip(tones, settings, labels(settings), strict=False):
            own = layer.like(setting)
            found = curve(own, *names_of(part, True))
            if found is None or own is None:
                continue
            f, s, _ = pooled(found, own)
            ax.plot(f, s, color=tone, linestyle=dash, linewidth=1.3 - 0.2 * place,
                    label="_" if place else title)  # fmt: skip
    if ax.has_data():
        ax.set_yscale("log")
        log_axis(ax.yaxis)
        frequency_axis(ax, "radial frequency [cycles/pixel]")
        ax.set_ylabel(f"power of the {PARTS[part]} [DN²]")
        for layer, dash in looks if len(looks) > 1 else ():  # names of the dashes
            ax.plot([], [], color=INK, linestyle=dash, linewidth=1.2, label=layer.label)
    return ax


def figure_2_of_two(one: Layer, other: Layer) -> Picture | None:
    """Radial spectra of all operating points of two sets of frames, such as raw and processed.

    Parameters
    ----------
    one, other : Layer
        Measured; each is drawn at its own operating points.
    """
    part = next((p for p in ("frame", *PARTS) if _spectra_of(one, p)), "frame")
    cells = [
        Cell(
            partial(draw_spectra_over, drawn=[layer], settings=_spectra_of(layer, part), part=part),
            5.05, 3.1, part, f"{PARTS[part]}, {layer.label}",
        )
        for layer in (one, other)
    ]  # fmt: skip
    return panels(
        cells,
        f"Radial power spectra of all operating points. Left: {one.label}; right: {other.label}.",
        f"Radial power spectra over the operating points: {one.label}, {other.label}.",
    )


def _spectra_of(layer: Layer, part: str) -> list[SettingStatistics]:
    return chosen(layer.statistics, MAX_POINTS, has(*names_of(part, True)))


def figure_2(drawn: Sequence[Layer], raw: Layer | None = None) -> Picture | None:
    """Radial spectra of all operating points on one axis, measured and model.

    Parameters
    ----------
    drawn : sequence of Layer
        The measured, and the model where there is one.
    raw : Layer, optional
        The model without its filters (defect correction, denoise), drawn beside what is processed.
    """
    measured = drawn[0].statistics
    parts, shown = parts_of(measured), chosen(measured, MAX_POINTS, has(*names_of("frame", True)))
    shown = shown or chosen(measured, MAX_POINTS)

    def cell(part: str, layers: Sequence[Layer], title: str) -> Cell:
        draw = partial(draw_spectra_over, drawn=layers, settings=shown, part=part)
        return Cell(draw, 5.05, 3.1, f"{part} {raw is not None}", title)

    cells = [cell(p, drawn, PARTS[p]) for p in parts]
    note = ""
    if raw is not None:
        kinds = [p for p in ("frame", *parts) if chosen(measured, 1, has(*names_of(p, True)))][:1]
        cells = [c for p in kinds for c in (
            cell(p, [raw], f"{PARTS[p]}, {raw.label}"),
            cell(p, drawn, f"{PARTS[p]}, processed: as in the files"),
        )]  # fmt: skip
        note = " Left: the model without its filters; right: the files and the model with them."
    return panels(
        cells,
        "Radial power spectra of all operating points." + note + plane_note(measured, shown),
        "Radial power spectra over the operating points.",
    )
