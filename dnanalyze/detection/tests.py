"""Tests to findings: each question with its null, its effect size and the effect that nature can
mimic.

A question is put to every view of every group. It is flagged only where its p-value survives Holm's
correction over all questions of the capture set *and* its effect exceeds what unfiltered
sensors show (``Finding.limit``): at a million pixels everything is significant.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import stats

from dnanalyze.detection.correlation import largest_crosstalk, shot_share
from dnanalyze.detection.edge import FEW, edge
from dnanalyze.detection.evidence import VIEWS, ViewEvidence
from dnanalyze.detection.excess import Excess, StandingOut
from dnanalyze.detection.replaced import RULES, Replaced
from dnanalyze.detection.results import Finding
from dnanalyze.detection.sharpness import tail
from dnanalyze.digits import minus
from dnanalyze.significance import CERTAIN, SIGN

# Effect sizes that unfiltered sensors reach (docs/detection.md): of noise with crosstalk taken off.
LIMITS = {
    "spectral_corner": 0.08,
    "crosstalk_or_denoise": 0.02,
    "rank_exceedance": 0.02,
    "median_equality": 0.14,
    "local_variance": 0.3,
    "wavelet_kurtosis": 0.3,
    "cap_to_neighbours": 0.9,
    "dynamic_threshold": 0.5,
    "ratio_rule": 0.5,
    "ratio_and_threshold": 0.5,
    "static_replacement": 5.0,
    "temporal_autocorrelation": 0.03,
    "row_phase": 0.03,
}
CAUSES = (
    "cap_to_neighbours", "dynamic_threshold", "ratio_rule", "ratio_and_threshold",
    "static_replacement",
)  # fmt: skip
BACKED = ("rank_exceedance", "local_variance", "wavelet_kurtosis")  # that never speak alone
CROSSTALK_ROOM = 1.1  # over the largest crosstalk's share, for the error of that share
CLUSTERED = 0.2  # share of hot pixels that still stand out where most come in clusters
HIGHEST_THRESHOLD = 64.0  # in units of the noise
ASKED_SLOPES = (2.0, 4.0)  # of a rule of ratio and threshold; each is one more test
SHARED = 40.0  # hum and 1/f noise, shared with neighbours, let more sites match by chance


def one_sided(value: float, se: float) -> float:
    """P(N(0, se) > value)."""
    return float(stats.norm.sf(value / se)) if np.isfinite(se) and se > 0 else 1.0


def _finding(
    e: ViewEvidence,
    test: str,
    p: float,
    effect: float,
    limit: float,
    words: str,
    kind: str = "",
    **points_to: Any,
) -> Finding:
    kind = kind or ("dpc" if test in CAUSES else "denoise")
    celsius, p = e.point.temperature_c, min(1.0, float(p))
    return Finding(
        test, kind, celsius, p, effect, False, e.view, words, limit, evidence=e, **points_to
    )


def smoothing(e: ViewEvidence, others: list[tuple[float, float | None]]) -> list[Finding]:
    """Has the noise been smoothed beyond what charge crosstalk can do to shot noise?"""
    if not e.usable:
        return []
    bound = largest_crosstalk(VIEWS[e.view])
    share = shot_share(e.correlation.variance, e.point.temperature_c, others) if e.temporal else 1.0
    room = CROSSTALK_ROOM * share
    (bend, bend_se), lag = e.spectrum.concavity(), e.correlation
    shared = lag.short_range_under_flicker if e.temporal else lag.short_range
    # the fixed pattern of one frame is less exchangeable
    extra = 0.0 if e.temporal else LIMITS["crosstalk_or_denoise"]
    asked = [
        _finding(
            e,
            "spectral_corner",
            # the chord that rises most was taken
            e.spectrum.independent_chords * one_sided(bend, bend_se),
            bend,
            LIMITS["spectral_corner"] + 2 * extra + room * bound.concavity,
            f"the spectrum of the noise is flat at low and falls at high frequencies: ln P lies "
            f"{bend:.2f} above a chord; for white noise with 1/f noise it lies below every chord",
        ),
        _finding(
            e,
            "crosstalk_or_denoise",
            one_sided(shared, lag.short_range_error),
            shared,
            LIMITS["crosstalk_or_denoise"] + extra + room * bound.short_range,
            f"the noise of neighbours has a correlation of {max(lag.along_rows[0], 0):.3f} along "
            f"rows and {max(lag.along_columns[0], 0):.3f} along columns; crosstalk, which does not "
            f"act on read noise, gives at most {share * bound.short_range:.3f} here",
        ),
    ]
    rarer_limit = LIMITS["rank_exceedance"] + extra + room * bound.extremes
    asked += _backed(e, any(a.score > 1 and a.p_value < 1e-6 for a in asked), rarer_limit)
    own, far, pixels = e.equal
    se = 2 * math.sqrt(max(far * (1 - far), 1 / pixels) / pixels)
    asked.append(
        _finding(
            e,
            "median_equality",
            one_sided(own - far, se),
            (own - far) / max(1 - far, 1e-6),
            LIMITS["median_equality"],
            f"{100 * own:.1f} % of the pixels equal their right neighbour, {100 * far:.1f} % equal "
            "a pixel farther away; a 3×3 median filter adds 21 %",
        )
    )
    return asked


def _backed(e: ViewEvidence, backed: bool, rarer_limit: float) -> list[Finding]:
    """Tests that tell the kind of a filter but never speak alone.

    Hum and strong 1/f noise make local extremes rarer, hits and clusters make noise uneven.
    """
    t, rarer, uneven = e.texture, 1 - e.extremes.extremes, e.texture.dispersion - 1
    asked = [
        (
            "rank_exceedance", rarer, e.extremes.se, rarer_limit,
            f"local extremes of the noise are {100 * rarer:.1f} % less frequent than for "
            "exchangeable pixels",
        ),
        (
            "local_variance", uneven, t.dispersion_se, LIMITS["local_variance"],
            "the noise varies over the field: the variances of 4×4 tiles scatter "
            f"{t.dispersion:.2f} times as much as those of independent pixels",
        ),
        (
            "wavelet_kurtosis", t.hh_excess, t.hh_se, LIMITS["wavelet_kurtosis"],
            f"the finest diagonal wavelet band has kurtosis {t.hh_kurtosis:.1f}, "
            f"{t.hh_excess:.1f} above that of independent pixels",
        ),
    ]  # fmt: skip
    return [
        _finding(e, test, one_sided(effect, se), effect, limit if backed else np.inf, words)
        for test, effect, se, limit, words in asked
    ]


def standing_out(e: ViewEvidence) -> list[Finding]:
    """Does something keep pixels from standing out of their neighbours?"""
    asked = []
    for out in (e.above8, e.above24):
        asked.append(_cap(e, out))
        asked.append(_end(e, out, out.difference, "dynamic_threshold"))
        asked.append(_end(e, out, out.ratio, "ratio_rule"))
        asked.append(_slope(e, out))
    return [a for a in asked if a is not None]


def _cap(e: ViewEvidence, out: StandingOut) -> Finding | None:
    top = out.difference
    own, control = (float(counts[0]) / top.frames for counts in (top.own, top.control))
    if control < 20:
        return None
    return _finding(
        e,
        "cap_to_neighbours",
        stats.poisson.cdf(math.floor(own), CLUSTERED * control),
        1 - own / control,
        LIMITS["cap_to_neighbours"],
        f"{own:.0f} pixels of a frame exceed the largest of their {out.neighbours} neighbours; "
        f"{control:.0f} exceed rings elsewhere: values are limited to those of the neighbours",
        at=0.0,
        neighbours=out.neighbours,
    )


def _end(e: ViewEvidence, out: StandingOut, top: Excess, test: str, slope: float = 1.0) -> Finding:
    """Does the tail end more sharply than clusters of hot pixels can end it?"""
    left, expected, fit = tail(top)
    if test != "ratio_rule":
        # below, read noise makes the tail; beyond, saturated charge spills over and hides the rest
        least = CERTAIN if slope > 1 else SIGN
        fit = fit & (top.bounds >= least * e.noise) & (top.bounds <= HIGHEST_THRESHOLD * e.noise)
    p = np.where(fit, stats.poisson.cdf(np.floor(left), expected), 1.0)
    j = int(np.argmin(p + 1e-9 * np.arange(p.size)))
    unit = "times" if test == "ratio_rule" else "DN above"
    times = "" if slope == 1 else f"{slope:g} times "
    return _finding(
        e,
        test,
        max(1, np.count_nonzero(fit)) * p[j],
        1 - float(left[j] / max(expected[j], 1e-9)) if fit[j] else 0.0,
        LIMITS[test],  # half of the least that clusters leave is missing
        f"{left[j]:.1f} pixels of a frame are {top.bounds[j]:.3g} to "
        f"{2 * top.bounds[j]:.3g} {unit} {times}the largest of their {out.neighbours} neighbours; "
        f"the tail below predicts at least {expected[j]:.0f}, even for hot pixels in clusters",
        at=edge(top, j),
        neighbours=out.neighbours,
        slope=slope,
    )


def _slope(e: ViewEvidence, out: StandingOut) -> Finding | None:
    """Rules of a ratio and a threshold together: 2 times the largest of 24 plus 400, say.

    Hits span pixels and would thin the tail likewise: asked only where they are taken out.
    """
    if e.frames < 3:
        return None
    asked = [_end(e, out, out.along(a), "ratio_and_threshold", a) for a in ASKED_SLOPES]
    best = min(asked, key=lambda a: a.p_value)
    return replace(best, p_value=min(1.0, best.p_value * len(ASKED_SLOPES)))


def sites(e: ViewEvidence) -> list[Finding]:
    """Are there sites that are always what their neighbours say, here or at all settings?"""
    asked = []
    if e.replaced is not None and e.replaced.tried:
        asked.append(_always(e, e.replaced, f"in all {e.replaced.frames} frames"))
    if e.listed is not None and e.listed.tried:
        where = f"in {e.listed.frames} frames of all operating points"
        asked.append(replace(_always(e, e.listed, where), temperature_c=None))
    return asked


def _always(e: ViewEvidence, seen: Replaced, where: str) -> Finding:
    own, control = seen.own, seen.control
    p = stats.poisson.sf(own - 1, 3 * control + 1)
    j = int(np.argmax(own / (control + 3)))
    matches = int(own[j])
    return _finding(
        e,
        "static_replacement",
        len(RULES) * p[j],
        float(matches / (control[j] + 1)) if matches > FEW else 0.0,
        LIMITS["static_replacement"] * _by_chance(e, seen, j),
        f"{matches} pixels equal the {RULES[j]} of their neighbours {where}; "
        f"{control[j]:.0f} equal that of a ring elsewhere",
        at=j,
        sites=seen,
    )


def _by_chance(e: ViewEvidence, seen: Replaced, rule: int) -> float:
    """How many times as many sites as in the control match because neighbours share noise.

    Sites that match in all K frames but one do so by chance: theirs to the power K / (K - 1).
    """
    shared = max(0.0, e.correlation.along_rows[0], e.correlation.along_columns[0])
    linear = 1 + SHARED * shared
    nearly = (seen.almost[rule] + FEW) / (seen.almost_control[rule] + FEW)
    return float(max(linear, nearly ** (seen.frames / (seen.frames - 1))))


def memory(e: ViewEvidence) -> list[Finding]:
    """Do pixels remember the frame before?"""
    if e.memory is None or not e.usable:
        return []
    m = e.memory
    return [
        _finding(
            e,
            "temporal_autocorrelation",
            m.p,
            min(m.everywhere, m.without_trend),
            LIMITS["temporal_autocorrelation"],
            f"the lag-1 autocorrelation over {m.frames} frames exceeds that of all pairs of "
            f"frames by {minus(f'{m.excess:.3f}')}: a recursive filter with a share of "
            f"{100 * m.memory:.0f} %",
            kind="temporal_denoise",
            at=m.memory,
        )
    ]


def row_phases(e: ViewEvidence) -> list[Finding]:
    """Are some rows, at a period, smoother than the rest?

    Not asked of one frame's fixed pattern: colours of other offsets lie in other rows.
    """
    r = e.rows
    if r is None or not e.usable or not e.temporal:
        return []
    return [
        _finding(
            e,
            "row_phase",
            r.p * max(r.tried, 1),
            r.effect,
            LIMITS["row_phase"],
            f"row {r.phase} of every {r.period} rows has {100 * r.effect:.1f} % fewer local "
            "extremes than the others",
            kind="dpc" if r.one_sided else "denoise",
            at=r.period,
        )
    ]
