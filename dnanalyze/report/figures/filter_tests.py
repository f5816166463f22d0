"""The tests for hidden filters: each statistic against its null, drawn from what `detect` kept."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from dnanalyze.detection.memory import expected_excess
from dnanalyze.detection.replaced import RULES
from dnanalyze.detection.results import Finding
from dnanalyze.detection.spectrum import CENTRES
from dnanalyze.report.figures.style import (
    GAUSSIAN,
    HAIRLINE,
    INK,
    MODEL,
    ORDER,
    PAPER,
    QUIET,
    Cell,
    Picture,
    axis_of,
    log_axis,
    panels,
)
from dnanalyze.report.words import point_label, varied

VIEWS = {"frame": (INK, "o", "whole frame"), "planes": (MODEL, "s", "within one colour plane")}
FLAGGED = GAUSSIAN
LIMIT = "limit of unfiltered sensors"
TITLES = {  # identifiers of the tests, readable
    "spectral_corner": "Spectral corner",
    "crosstalk_or_denoise": "Correlation of neighbours",
    "median_equality": "Equal neighbours",
    "rank_exceedance": "Local extremes",
    "local_variance": "Local variance",
    "wavelet_kurtosis": "Wavelet kurtosis",
    "cap_to_neighbours": "Values capped at a neighbour",
    "dynamic_threshold": "Dynamic threshold",
    "ratio_rule": "Ratio rule",
    "ratio_and_threshold": "Ratio and threshold",
    "static_replacement": "Static replacement",
    "row_phase": "Some rows only",
    "temporal_autocorrelation": "Correlation from frame to frame",
    "recursive_memory": "Equivalent recursive filter",
}
OF = {"recursive_memory": "temporal_autocorrelation"}  # what is drawn of another test's finding
SAYS = {  # what the vertical axis of a test that is drawn over the settings holds
    "crosstalk_or_denoise": "corr. at 1 px − 2.5 × corr. at 2 px",
    "median_equality": "excess of equal neighbours",
    "rank_exceedance": "missing share of extremes",
    "local_variance": "variance of 4×4 variances − 1",
    "wavelet_kurtosis": "excess kurtosis",
    "cap_to_neighbours": "share of capped pixels",
    "temporal_autocorrelation": "lag-1 correlation + 1/K",
    "row_phase": "extremes missing in some rows",
}
ERRORS: dict[str, Callable[[Any], float]] = {
    "crosstalk_or_denoise": lambda e: 3 * e.correlation.se,
    "rank_exceedance": lambda e: e.extremes.se,
    "local_variance": lambda e: e.texture.dispersion_se,
    "wavelet_kurtosis": lambda e: e.texture.hh_se,
    "temporal_autocorrelation": lambda e: e.memory.shared_se,
}
ALL = (
    "Bars: two standard errors. Line at 0: an unfiltered sensor with identical pixels. Grey "
    "dashes: the limit of unfiltered sensors. Orange: flagged. Open symbols: not used as evidence."
)
SMOOTHING = (
    "Tests for spatial denoise. Spectral corner: the logarithm of the spectrum of white noise and "
    "1/f noise is convex, so no point of an unfiltered sensor lies above a chord (dashed). " + ALL
)
CORRECTIONS = (
    "Tests for defect-pixel correction. Thresholds: pixels per frame that exceed their own "
    "neighbours (solid) and other pixels' neighbours (dashed) by more than the value on the axis, "
    "at the most significant operating point; a correction ends the tail at its threshold "
    "(vertical line). Static replacement: pixels that equal, in every frame, a function of their "
    "neighbours (dot) or of other pixels' neighbours (bar). " + ALL
)
REMEMBERING = (
    "Test for temporal denoise: correlation of successive frames less the mean correlation of all "
    "pairs of frames, which is about −1/K for K frames, and the memory of the recursive filter "
    "that would give it. " + ALL
)


def smoothing(findings: Sequence[Finding]) -> Picture | None:
    """The tests for spatial denoise.

    Parameters
    ----------
    findings : sequence of Finding
        Of one `Detection`.
    """
    tests = (
        "spectral_corner", "crosstalk_or_denoise", "median_equality", "rank_exceedance",
        "local_variance", "wavelet_kurtosis",
    )  # fmt: skip
    return _panels(findings, tests, SMOOTHING, "Tests for spatial denoise.")


def corrections(findings: Sequence[Finding]) -> Picture | None:
    """The tests for defect-pixel correction, and for rows that alone are filtered."""
    tests = (
        "cap_to_neighbours", "dynamic_threshold", "ratio_rule", "ratio_and_threshold",
        "static_replacement", "row_phase",
    )  # fmt: skip
    return _panels(findings, tests, CORRECTIONS, "Tests for defect-pixel correction.")


def remembering(findings: Sequence[Finding]) -> Picture | None:
    """The test for temporal denoise, and what recursive memory it would mean."""
    tests = ("temporal_autocorrelation", "recursive_memory")
    return _panels(findings, tests, REMEMBERING, "Test for temporal denoise.")


def draw_test(ax: Any, findings: Sequence[Finding], test: str) -> Any:
    """One test: its statistic, the standard errors, and what unfiltered sensors reach.

    Parameters
    ----------
    ax : matplotlib axes
    findings : sequence of Finding
        Of one `Detection`.
    test : str
        A key of `TITLES`.
    """
    asked = OF.get(test, test)
    own = [a for a in findings if a.test == asked and a.evidence]
    if own:
        PAINT.get(test, _over_settings)(ax, asked, own)
    return ax


def _panels(
    findings: Sequence[Finding], tests: Sequence[str], caption: str, alt: str
) -> Picture | None:
    def cell(test: str) -> Cell:
        def draw(ax: Any) -> None:
            draw_test(ax, findings, test)
            ax.set_title(TITLES[test] + ax.get_title(loc="left"))

        return Cell(draw, 3.35, 2.6)

    return panels([cell(t) for t in tests], caption, alt)


def _over_settings(ax: Any, test: str, findings: Sequence[Finding]) -> None:
    x, label = _places([a.evidence for a in findings])
    for finding, at in zip(findings, x, strict=True):
        colour, sign, name = VIEWS[finding.evidence.view]
        colour, name = (FLAGGED, "flagged") if finding.flagged else (colour, name)
        if test in ERRORS:
            se = 2 * ERRORS[test](finding.evidence)
            ax.vlines(
                at, finding.effect_size - se, finding.effect_size + se, color=colour, linewidth=1.0
            )
        speaks = finding.counts and np.isfinite(finding.limit)
        ax.plot(at, finding.effect_size, sign, color=colour, markersize=3.8, markeredgewidth=0.9,
                markerfacecolor=colour if speaks else PAPER,
                label=name if speaks else f"{name}, not used")  # fmt: skip
        if speaks:
            ax.plot(at, finding.limit, "_", color=QUIET, markersize=11, markeredgewidth=1.2,
                    label=LIMIT)  # fmt: skip
    ax.axhline(0, color=QUIET, linewidth=0.8, zorder=0.5)
    ax.set_xlabel(label)
    ax.set_ylabel(SAYS[test])
    ax.margins(x=0.08, y=0.12)
    if label == ORDER:
        ax.set_xticks(np.unique(x))
        ax.set_xlim(x.min() - 0.5, x.max() + 0.5)


def _places(seen: Sequence[Any]) -> tuple[np.ndarray, str]:
    """Where each stands on the axis of settings, and the axis' label."""
    key, x, label = axis_of(seen)
    if key:
        return x, label
    points = list(dict.fromkeys(e.point for e in seen))
    return np.array([1.0 + points.index(e.point) for e in seen]), label


def _telling(findings: Sequence[Finding]) -> Any:
    """The finding that says most: flagged and farthest beyond its limit, else the least likely."""
    return max(findings, key=lambda a: (a.flagged, min(a.score, 1e3), -a.p_value))


def _colour(finding: Any) -> str:
    return FLAGGED if finding.flagged else VIEWS[finding.evidence.view][0]


def _name(ax: Any, finding: Any, among: Sequence[Finding]) -> None:
    """The operating point follows the title: what differs from the others."""
    e = finding.evidence
    apart = varied(vars(a.evidence.point) for a in among)
    point = "all operating points" if finding.everywhere else point_label(e.point, apart)
    ax.set_title(f", {point}" + (", one colour" if e.view == "planes" else ""))


def _spectrum(ax: Any, _test: str, findings: Sequence[Finding]) -> None:
    telling = _telling(findings)
    view = telling.evidence.view
    for finding in [a for a in findings if a.evidence.view == view and a is not telling]:
        spectrum = finding.evidence.spectrum
        ax.plot(2**CENTRES, spectrum.log_power, color=QUIET, linewidth=0.7, alpha=0.7)
    spectrum = telling.evidence.spectrum
    ax.errorbar(2**CENTRES, spectrum.log_power, 2 * spectrum.se, color=_colour(telling),
                marker="o", markersize=3.5, linewidth=1.2)  # fmt: skip
    chord = spectrum.chord()
    if chord is not None:
        ends = [chord.octaves[0], chord.octaves[2]]
        ax.plot(2 ** CENTRES[ends], spectrum.log_power[ends], color=INK, linewidth=1.0,
                linestyle=(0, (4, 2)))  # fmt: skip
    ax.set_xscale("log")
    log_axis(ax.xaxis)
    ax.set_xlabel("spatial frequency [cycles/pixel]")
    ax.set_ylabel("ln(power / DN²)")
    _name(ax, telling, findings)


def _survival(ax: Any, test: str, findings: Sequence[Finding]) -> None:
    telling = _telling(findings)
    e = telling.evidence
    out = e.above(telling.neighbours)
    ratio = test == "ratio_rule"
    top = out.ratio if ratio else out.difference
    if test == "ratio_and_threshold":
        top = out.along(telling.slope)
    own, control = top.own / top.frames, top.control / top.frames
    if not own.any() and not control.any():  # no pixel stands out: nothing to draw
        return
    ax.plot(top.bounds, control, color=INK, linewidth=1.0, linestyle=(0, (4, 2)))
    ax.plot(top.bounds, np.maximum(own, 0.5 / top.frames), color=_colour(telling), linewidth=1.6,
            label="flagged" if telling.flagged else None)  # fmt: skip
    if telling.flagged:
        ax.axvline(telling.at, color=FLAGGED, linewidth=0.8)
    some = top.bounds[control >= 1 / top.frames]
    low = 1.0 if ratio else 2 * e.noise
    ax.set_xscale("log")
    ax.set_xlim(low, max(2 * low, float(some[-1]) if some.size else 0))
    ax.set_yscale("log")
    most = float(control[np.searchsorted(top.bounds, low)])
    ax.set_ylim(0.5 / top.frames, max(2.0, 2 * most))
    log_axis(ax.xaxis)
    log_axis(ax.yaxis)
    times = "" if telling.slope == 1 else f"{telling.slope:g} × "
    of = f"{times}largest of {out.neighbours} neighbours"
    ax.set_xlabel(f"pixel / {of}" if ratio else f"pixel − {of} [DN]")
    ax.set_ylabel("pixels per frame")
    _name(ax, telling, findings)


def _sites(ax: Any, _test: str, findings: Sequence[Finding]) -> None:
    telling = _telling(findings)
    found = telling.sites
    y = np.arange(len(RULES))[::-1]
    colours = [FLAGGED if telling.flagged and k == telling.at else INK for k in range(len(RULES))]
    ax.barh(y, found.control, height=0.62, color=HAIRLINE)
    ax.scatter(found.own, y, s=16, color=colours, zorder=3, clip_on=False)
    ax.set_xscale("symlog", linthresh=10)
    ax.set_xlim(0, 2 * max(10, int(found.own.max()), int(found.control.max())))
    ax.set_xticks([t for t in (0, 10, 100, 1000, 10000, 100000) if t <= ax.get_xlim()[1]])
    ax.xaxis.set_major_formatter(lambda value, _: f"{value:,.0f}")
    ax.set_yticks(y, RULES, fontsize=6.5)
    ax.grid(axis="y", visible=False)
    ax.set_xlabel("pixels")
    _name(ax, telling, findings)


def _memory(ax: Any, _test: str, findings: Sequence[Finding]) -> None:
    telling = _telling(findings)
    measured = telling.evidence.memory
    share = np.linspace(0, 0.9, 46)
    expected = [expected_excess(a, measured.frames) for a in share]
    ax.plot(share, expected, color=INK, linewidth=1.2)
    found = expected_excess(measured.memory, measured.frames)
    ax.plot(measured.memory, found, "o", color=_colour(telling), markersize=5, zorder=3)
    ax.axhline(telling.limit, color=QUIET, linewidth=0.8, linestyle=(0, (4, 2)))
    ax.set_xlabel("weight of the previous frame")
    ax.set_ylabel(SAYS["temporal_autocorrelation"])
    _name(ax, telling, findings)


PAINT: dict[str, Callable[[Any, str, Sequence[Finding]], None]] = {  # the others: over the settings
    "spectral_corner": _spectrum,
    "dynamic_threshold": _survival,
    "ratio_rule": _survival,
    "ratio_and_threshold": _survival,
    "static_replacement": _sites,
    "recursive_memory": _memory,
}
