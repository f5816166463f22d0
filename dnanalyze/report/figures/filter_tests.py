"""The tests for hidden filters: each statistic against its null, drawn from what `detect` kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from dnanalyze.detection.memory import expected_excess
from dnanalyze.detection.replaced import RULES
from dnanalyze.detection.spectrum import CENTRES
from dnanalyze.report.figures.style import (
    GAUSSIAN,
    INK,
    MODEL,
    QUIET,
    Picture,
    axis_of,
    figure,
    log_axis,
    picture,
)
from dnanalyze.report.words import point_label

VIEWS = {"frame": (INK, "o", "whole frame"), "planes": (MODEL, "s", "within a colour")}
FLAGGED = GAUSSIAN
SAYS = {  # what the vertical axis of a test that is drawn over the settings holds
    "crosstalk_or_denoise": "correlation: next less 2.5 x second",
    "median_equality": "surplus of equal neighbours",
    "rank_exceedance": "local extremes missing",
    "local_variance": "scatter of 4x4 variances, above 1",
    "wavelet_kurtosis": "kurtosis in excess",
    "cap_to_neighbours": "share capped",
    "temporal_autocorrelation": "lag-1 correlation + 1/K",
    "row_phase": "extremes missing in some rows",
}
ERRORS: dict[str, Callable[[Any], float]] = {
    "crosstalk_or_denoise": lambda e: 3 * e.correlation.se,
    "rank_exceedance": lambda e: e.rank[8].se,
    "local_variance": lambda e: e.texture.dispersion_se,
    "wavelet_kurtosis": lambda e: e.texture.hh_se,
    "temporal_autocorrelation": lambda e: e.memory.shared_se,
}
ALL = (
    "Bars: two standard errors; the line at 0: an unfiltered sensor whose pixels are alike; "
    "dashes: what unfiltered sensors reach, where the test may speak; orange: flagged."
)
SMOOTHING = (
    "Spatial denoise. Spectrum: ln P of white noise with 1/f noise is convex, so nothing rises "
    f"above a chord (dashed). {ALL} Open signs: warmer settings, where crosstalk smooths shot "
    "noise, and tests that never speak alone."
)
CORRECTIONS = (
    "Defect-pixel correction. Pixels a frame that stand out of their own neighbours (solid) and"
    " of rings elsewhere (dashed) by more than a bound, at the setting that says most. Clusters"
    " of hot pixels thin the tail smoothly; a correction ends it at its threshold (vertical). "
    "Sites: pixels that are in every frame what a rule makes of their neighbours (dot), or of a"
    " ring elsewhere (bar). Cap: elsewhere the larger of two rings is taken, so unfiltered "
    "sensors lie below 0. Row phase: the one of many that departs most, so above 0 by chance. "
    f"{ALL}"
)
REMEMBERING = (
    "Temporal denoise. Left: autocorrelation from frame to frame, less that of all pairs of "
    f"frames, about -1/K. {ALL} Right: the recursive memory that would explain it."
)


def smoothing(answers: Sequence[Any]) -> Picture | None:
    """The tests for spatial denoise.

    Parameters
    ----------
    answers : sequence of Answer
        Of one `Detection`.
    """
    panels = [("spectral_corner", _spectrum)] + [
        (test, _over_settings)
        for test in (
            "crosstalk_or_denoise", "median_equality", "rank_exceedance", "local_variance",
            "wavelet_kurtosis",
        )
    ]  # fmt: skip
    return _grid(
        answers, panels, 3,
        SMOOTHING,
        "Tests for spatial denoise, each against its null.",
    )  # fmt: skip


def corrections(answers: Sequence[Any]) -> Picture | None:
    """The tests for defect-pixel correction, and for rows that alone are filtered."""
    panels = [
        ("cap_to_neighbours", _over_settings), ("dynamic_threshold", _survival),
        ("ratio_rule", _survival), ("ratio_and_threshold", _survival),
        ("static_replacement", _sites), ("row_phase", _over_settings),
    ]  # fmt: skip
    return _grid(
        answers, panels, 3,
        CORRECTIONS,
        "Tests for defect-pixel correction, each against its null.",
    )  # fmt: skip


def remembering(answers: Sequence[Any]) -> Picture | None:
    """The test for temporal denoise, and what recursive memory it would mean."""
    panels = [("temporal_autocorrelation", _over_settings), ("temporal_autocorrelation", _memory)]
    return _grid(
        answers, panels, 2,
        REMEMBERING,
        "Test for temporal denoise against its null.",
    )  # fmt: skip


def _grid(
    answers: Sequence[Any], panels: Sequence[tuple[str, Callable[..., None]]], columns: int,
    caption: str, alt: str,
) -> Picture | None:  # fmt: skip
    of = {test: [a for a in answers if a.asked.test == test] for test, _ in panels}
    if not any(of.values()):
        return None

    def draw() -> Any:
        rows = -(-len(panels) // columns)
        fig, axes = figure(rows, columns, 2.5 * rows + 0.4)
        for ax, (test, paint) in zip(axes.flat, panels, strict=True):
            ax.set_title(test.replace("_", " "))
            if of[test]:
                paint(ax, test, of[test])
            else:
                ax.text(0.5, 0.5, "not asked of these frames", transform=ax.transAxes, ha="center",
                        color=QUIET)  # fmt: skip
                ax.set_xticks([])
                ax.set_yticks([])
        _legend(fig, [a for some in of.values() for a in some])
        return fig

    return picture(draw, caption, alt)


def _legend(fig: Any, shown: Sequence[Any]) -> None:
    from matplotlib.lines import Line2D

    seen = {a.asked.evidence.view for a in shown}
    signs = [VIEWS[v] for v in VIEWS if v in seen]
    if any(a.flagged for a in shown):
        signs.append((FLAGGED, "o", "flagged"))
    handles = [
        Line2D([], [], color=c, marker=m, linestyle="none", markersize=4, label=text)
        for c, m, text in signs
    ]
    handles.append(Line2D([], [], color=QUIET, marker="_", linestyle="none", label="limit"))
    fig.legend(handles=handles, loc="outside upper left", ncols=len(handles), borderaxespad=0.2)


def _over_settings(ax: Any, test: str, answers: Sequence[Any]) -> None:
    x, label = _places([a.asked.evidence for a in answers])
    ax.axhline(0, color=QUIET, linewidth=0.8)
    for answer, at in zip(answers, x, strict=True):
        asked = answer.asked
        colour, sign, _ = VIEWS[asked.evidence.view]
        colour = FLAGGED if answer.flagged else colour
        if test in ERRORS:
            se = 2 * ERRORS[test](asked.evidence)
            ax.vlines(at, asked.effect - se, asked.effect + se, color=colour, linewidth=1.0)
        speaks = answer.judge and np.isfinite(asked.limit)
        ax.plot(at, asked.effect, sign, color=colour, markersize=3.8,
                markerfacecolor=colour if speaks else "white", markeredgewidth=0.9)  # fmt: skip
        if speaks:
            ax.plot(at, asked.limit, "_", color=QUIET, markersize=11, markeredgewidth=1.2)
    ax.set_xlabel(label)
    ax.set_ylabel(SAYS[test])
    ax.margins(x=0.08, y=0.12)
    if label == "operating point":
        ax.set_xticks(np.unique(x))
        ax.set_xlim(x.min() - 0.5, x.max() + 0.5)


def _places(seen: Sequence[Any]) -> tuple[np.ndarray, str]:
    """Where each stands on the axis of settings, and the axis' label."""
    key, x, label = axis_of(seen)
    if key:
        return x, label
    points = list(dict.fromkeys(e.point for e in seen))
    return np.array([1.0 + points.index(e.point) for e in seen]), label


def _telling(answers: Sequence[Any]) -> Any:
    """The answer that says most: flagged and farthest beyond its limit, else the least likely."""
    return max(
        answers, key=lambda a: (a.flagged, min(a.asked.effect / a.asked.limit, 1e3), -a.asked.p)
    )


def _name(ax: Any, answer: Any) -> None:
    e = answer.asked.evidence
    point = "all settings" if answer.asked.everywhere else point_label(e.point)
    where = point + (", within a colour" if e.view == "planes" else "")
    ax.annotate(where, (1, 1), (0, 5), xycoords="axes fraction", textcoords="offset points",
                ha="right", fontsize=7.2, color=FLAGGED if answer.flagged else QUIET)  # fmt: skip


def _spectrum(ax: Any, _test: str, answers: Sequence[Any]) -> None:
    telling = _telling(answers)
    view = telling.asked.evidence.view
    for answer in [a for a in answers if a.asked.evidence.view == view and a is not telling]:
        spectrum = answer.asked.evidence.spectrum
        ax.plot(2**CENTRES, spectrum.log_power, color=QUIET, linewidth=0.7, alpha=0.7)
    spectrum = telling.asked.evidence.spectrum
    colour = FLAGGED if telling.flagged else VIEWS[view][0]
    ax.errorbar(2**CENTRES, spectrum.log_power, 2 * spectrum.se, color=colour, marker="o",
                markersize=3.5, linewidth=1.2)  # fmt: skip
    chord = spectrum.chord()
    if chord is not None:
        ends = [chord.octaves[0], chord.octaves[2]]
        ax.plot(2 ** CENTRES[ends], spectrum.log_power[ends], color=INK, linewidth=1.0,
                linestyle=(0, (4, 2)))  # fmt: skip
    ax.set_xscale("log")
    log_axis(ax.xaxis)
    ax.set_xlabel("cycles/pixel")
    ax.set_ylabel("ln P [DN²]")
    _name(ax, telling)


def _survival(ax: Any, test: str, answers: Sequence[Any]) -> None:
    telling = _telling(answers)
    asked = telling.asked
    e = asked.evidence
    out = e.above8 if asked.neighbours == 8 else e.above24
    ratio = test == "ratio_rule"
    top = out.ratio if ratio else out.difference
    if test == "ratio_and_threshold":
        top = out.along(asked.slope)
    colour = FLAGGED if telling.flagged else VIEWS[e.view][0]
    own, control = top.own / top.frames, top.control / top.frames
    ax.plot(top.bounds, control, color=INK, linewidth=1.0, linestyle=(0, (4, 2)))
    ax.plot(top.bounds, np.maximum(own, 0.5 / top.frames), color=colour, linewidth=1.6)
    if telling.flagged:
        ax.axvline(asked.at, color=colour, linewidth=0.8)
    some = top.bounds[control >= 1 / top.frames]
    low = 1.0 if ratio else 2 * e.noise
    ax.set_xscale("log")
    ax.set_xlim(low, max(2 * low, float(some[-1]) if some.size else 0))
    ax.set_yscale("log")
    most = float(control[np.searchsorted(top.bounds, low)])
    ax.set_ylim(0.5 / top.frames, max(2.0, 2 * most))
    log_axis(ax.xaxis)
    log_axis(ax.yaxis)
    unit = "times" if ratio else "DN above"
    times = "" if asked.slope == 1 else f"{asked.slope:g} x "
    ax.set_xlabel(f"{unit} {times}the largest of {out.neighbours}")
    ax.set_ylabel("pixels a frame")
    _name(ax, telling)


def _sites(ax: Any, _test: str, answers: Sequence[Any]) -> None:
    telling = _telling(answers)
    found = telling.asked.sites
    y = np.arange(len(RULES))[::-1]
    colours = [
        FLAGGED if telling.flagged and k == telling.asked.at else INK for k in range(len(RULES))
    ]
    ax.barh(y, found.control, height=0.62, color="#d9dee3")
    ax.scatter(found.own, y, s=16, color=colours, zorder=3, clip_on=False)
    ax.set_xscale("symlog", linthresh=10)
    ax.set_xlim(0, 2 * max(10, int(found.own.max()), int(found.control.max())))
    ax.set_xticks([t for t in (0, 10, 100, 1000, 10000, 100000) if t <= ax.get_xlim()[1]])
    ax.xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}")
    ax.set_yticks(y, RULES, fontsize=6.5)
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("sites")
    _name(ax, telling)


def _memory(ax: Any, _test: str, answers: Sequence[Any]) -> None:
    telling = _telling(answers)
    measured = telling.asked.evidence.memory
    share = np.linspace(0, 0.9, 46)
    expected = [expected_excess(a, measured.frames) for a in share]
    colour = FLAGGED if telling.flagged else VIEWS[telling.asked.evidence.view][0]
    ax.plot(share, expected, color=INK, linewidth=1.2)
    found = expected_excess(measured.memory, measured.frames)
    ax.plot(measured.memory, found, "o", color=colour, markersize=5, zorder=3)
    ax.axhline(telling.asked.limit, color=QUIET, linewidth=0.8, linestyle=(0, (4, 2)))
    ax.annotate("limit", (0.9, telling.asked.limit), (0, 2), textcoords="offset points",
                ha="right", color=QUIET)  # fmt: skip
    ax.set_title("as a recursive memory")
    ax.set_xlabel("memory")
    ax.set_ylabel(SAYS["temporal_autocorrelation"])
    _name(ax, telling)
