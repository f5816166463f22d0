"""Tests to findings: each question with its null, its effect size and the effect that nature can
mimic.

A question is put to every view of every group. It is flagged only where its p-value survives Holm's
correction over all questions of the capture set *and* its effect exceeds what unfiltered
sensors show (``FilterTest.limit``): at a million pixels everything is significant.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy import stats

from dnanalyze.detection.correlation import largest_crosstalk, shot_share
from dnanalyze.detection.evidence import ViewEvidence
from dnanalyze.detection.excess import Excess, StandingOut
from dnanalyze.detection.replaced import RULES, Replaced
from dnanalyze.detection.sharpness import tail
from dnanalyze.digits import minus
from dnanalyze.significance import SIGN

CLUSTERED = 0.2  # share of hot pixels that still stand out where most come in clusters
HOTTER = 8.0  # in units of the noise, from which rules of a slope are asked
HIGHEST_THRESHOLD = 64.0  # in units of the noise
ASKED_SLOPES = (2.0, 4.0)
TRIED = 8  # independent bounds, about: the counts of bounds within a factor of 2 overlap
LEAST_SITES = 6.0  # expected pixels beyond a bound, a frame, below which no edge is placed there
LEAST_REPLACED = 8
SHARED = 40.0  # hum and 1/f noise, shared with neighbours, let more sites match by chance
FEW_SITES = 5.0
NEIGHBOUR_STEP = {"frame": 1, "planes": 2}  # pixels between the neighbours of a view


@dataclass(frozen=True)
class FilterTest:
    """A question with its answer: flagged where p is small and effect > limit."""

    test: str
    kind: str
    evidence: ViewEvidence
    p: float
    effect: float
    limit: float
    words: str
    at: float = np.nan  # threshold, ratio or rule that the answer points to
    neighbours: int = 8
    slope: float = 1.0  # of the neighbours' maximum, in a rule of a slope and a bound
    sites: Replaced | None = None  # that the answer rests on

    @property
    def everywhere(self) -> bool:
        """Over all settings."""
        return self.sites is not None and self.sites is self.evidence.listed


def one_sided(value: float, se: float) -> float:
    """P(N(0, se) > value)."""
    return float(stats.norm.sf(value / se)) if np.isfinite(se) and se > 0 else 1.0


def smoothing(e: ViewEvidence, others: list[tuple[float, float | None]]) -> list[FilterTest]:
    """Has the noise been smoothed beyond what charge crosstalk can do to shot noise?"""
    if not e.usable:
        return []
    bound = largest_crosstalk(NEIGHBOUR_STEP[e.view])
    share = shot_share(e.correlation.variance, e.point.temperature_c, others) if e.temporal else 1.0
    room = 1.1 * share
    (bend, bend_se), lag = e.spectrum.concavity(), e.correlation
    shared = lag.short_range_under_flicker if e.temporal else lag.short_range
    extra = 0.0 if e.temporal else 0.02  # the fixed pattern of one frame is less exchangeable
    chords = e.spectrum.independent_chords  # the one that rises most was taken
    denoise = partial(_denoise, e)
    asked = [
        denoise(
            "spectral_corner",
            min(1.0, chords * one_sided(bend, bend_se)),
            bend,
            0.08 + 2 * extra + room * bound.concavity,
            f"the spectrum of the noise is flat at low and falls at high frequencies: ln P lies "
            f"{bend:.2f} above a chord; for white noise with 1/f noise it lies below every chord",
        ),
        denoise(
            "crosstalk_or_denoise",
            one_sided(shared, lag.short_range_error),
            shared,
            0.02 + extra + room * bound.short_range,
            f"the noise of neighbours has a correlation of {max(lag.along_rows[0], 0):.3f} along "
            f"rows and {max(lag.along_columns[0], 0):.3f} along columns; crosstalk, which does not "
            f"act on read noise, gives at most {share * bound.short_range:.3f} here",
        ),
    ]
    asked += _backed(
        e,
        any(a.effect > a.limit and a.p < 1e-6 for a in asked),
        0.02 + extra + room * bound.extremes,
    )
    own, far, pixels = e.equal
    repeat = (own - far) / max(1 - far, 1e-6)
    se = np.sqrt(max(far * (1 - far), 1 / pixels) / pixels) * 2
    asked.append(
        denoise(
            "median_equality",
            one_sided(own - far, se),
            repeat,
            0.14,
            f"{100 * own:.1f} % of the pixels equal their right neighbour, {100 * far:.1f} % equal "
            "a pixel farther away; a 3×3 median filter adds 21 %",
        )
    )
    return asked


def _denoise(
    e: ViewEvidence, test: str, p: float, effect: float, limit: float, words: str
) -> FilterTest:
    return FilterTest(test, "denoise", e, p, effect, limit, words)


def _backed(e: ViewEvidence, backed: bool, rarer_limit: float) -> list[FilterTest]:
    """Tests that tell the kind of a filter but never speak alone.

    Hum and strong 1/f noise make local extremes rarer, hits and clusters make noise uneven.
    """
    rank, t = e.rank[8], e.texture
    rarer, uneven = 1 - rank.extremes, t.dispersion - 1
    denoise = partial(_denoise, e)
    return [
        denoise(
            "rank_exceedance",
            one_sided(rarer, rank.se),
            rarer,
            rarer_limit if backed else np.inf,
            f"local extremes of the noise are {100 * rarer:.1f} % less frequent than for "
            "exchangeable pixels",
        ),
        denoise(
            "local_variance",
            one_sided(uneven, t.dispersion_se),
            uneven,
            0.3 if backed else np.inf,
            "the noise varies over the field: the variances of 4×4 tiles scatter "
            f"{t.dispersion:.2f} times as much as those of independent pixels",
        ),
        denoise(
            "wavelet_kurtosis",
            one_sided(t.hh_excess, t.hh_se),
            t.hh_excess,
            0.3 if backed else np.inf,
            f"the finest diagonal wavelet band has kurtosis {t.hh_kurtosis:.1f}, "
            f"{t.hh_excess:.1f} above that of independent pixels",
        ),
    ]


def standing_out(e: ViewEvidence) -> list[FilterTest]:
    """Does something keep pixels from standing out of their neighbours?"""
    asked = []
    for out in (e.above8, e.above24):
        asked.append(_cap(e, out))
        asked.append(_end(e, out, out.difference, "dynamic_threshold", 1.0))
        asked.append(_end(e, out, out.ratio, "ratio_rule", 1.0))
        asked.append(_slope(e, out))
    return [a for a in asked if a is not None]


def _cap(e: ViewEvidence, out: StandingOut) -> FilterTest | None:
    top, count = out.difference, out.neighbours
    control = float(top.control[0]) / top.frames
    own = float(top.own[0]) / top.frames
    if control < 20:
        return None
    return FilterTest(
        "cap_to_neighbours", "dpc", e, float(stats.poisson.cdf(np.floor(own), CLUSTERED * control)),
        1 - own / control, 0.9,
        f"{own:.0f} pixels of a frame exceed the largest of their {count} neighbours; "
        f"{control:.0f} exceed rings elsewhere: values are limited to those of the neighbours",
        0.0, count,
    )  # fmt: skip


def _end(e: ViewEvidence, out: StandingOut, top: Excess, test: str, slope: float) -> FilterTest:
    """Does the tail end more sharply than clusters of hot pixels can end it?"""
    seen = tail(top)
    fit = seen.shown
    if test != "ratio_rule":
        # below, read noise makes the tail; beyond, saturated charge spills over and hides the rest
        least = HOTTER if slope > 1 else SIGN
        fit = fit & (top.bounds >= least * e.noise) & (top.bounds <= HIGHEST_THRESHOLD * e.noise)
    p = np.where(fit, stats.poisson.cdf(np.floor(seen.left), seen.least), 1.0)
    j = int(np.argmin(p + 1e-9 * np.arange(p.size)))
    unit = "times" if test == "ratio_rule" else "DN above"
    times = "" if slope == 1 else f"{slope:g} times "
    return FilterTest(
        test, "dpc", e, min(1.0, float(p[j]) * TRIED),
        1 - float(seen.left[j] / max(seen.least[j], 1e-9)) if fit[j] else 0.0,
        0.5,  # half of the least that clusters leave is missing
        f"{seen.left[j]:.1f} pixels of a frame are {top.bounds[j]:.3g} to "
        f"{2 * top.bounds[j]:.3g} {unit} {times}the largest of their {out.neighbours} neighbours; "
        f"the tail below predicts at least {seen.least[j]:.0f}, even for hot pixels in clusters",
        edge(top, j), out.neighbours, slope,
    )  # fmt: skip


def _slope(e: ViewEvidence, out: StandingOut) -> FilterTest | None:
    """Rules of a ratio and a threshold together: 2 times the largest of 24 plus 400, say.

    Hits span pixels and would thin the tail likewise: asked only where they are taken out.
    """
    if e.frames < 3:
        return None
    asked = [_end(e, out, out.along(a), "ratio_and_threshold", a) for a in ASKED_SLOPES]
    best = min(asked, key=lambda a: a.p)
    return replace(best, p=min(1.0, best.p * len(ASKED_SLOPES)))


def edge(top: Excess, j: int) -> float:
    """The smallest bound beyond which (almost) nothing is left, from the ``j``-th down."""
    empty = top.own <= 0.02 * top.control
    while j > 0 and empty[j - 1] and top.control[j - 1] > 0:
        j -= 1
    return float(top.bounds[j])


def sites(e: ViewEvidence) -> list[FilterTest]:
    """Are there sites that are always what their neighbours say, here or at all settings?"""
    asked = []
    if e.replaced is not None and e.replaced.tried:
        asked.append(_always(e, e.replaced, f"in all {e.replaced.frames} frames"))
    if e.listed is not None and e.listed.tried:
        where = f"in {e.listed.frames} frames of all operating points"
        asked.append(_always(e, e.listed, where))
    return asked


def _always(e: ViewEvidence, seen: Replaced, where: str) -> FilterTest:
    own, control = seen.own, seen.control
    p = stats.poisson.sf(own - 1, 3 * control + 1)
    j = int(np.argmax(own / (control + 3)))
    matches = int(own[j])
    return FilterTest(
        "static_replacement",
        "dpc",
        e,
        min(1.0, float(p[j]) * len(RULES)),
        float(matches / (control[j] + 1)) if matches >= LEAST_REPLACED else 0.0,
        5.0 * _by_chance(e, seen, j),
        f"{matches} pixels equal the {RULES[j]} of their neighbours {where}; "
        f"{control[j]:.0f} equal that of a ring elsewhere",
        j,
        sites=seen,
    )


def _by_chance(e: ViewEvidence, seen: Replaced, rule: int) -> float:
    """How many times as many sites as in the control match because neighbours share noise.

    Sites that match in all K frames but one do so by chance: theirs to the power K / (K - 1).
    """
    shared = max(0.0, e.correlation.along_rows[0], e.correlation.along_columns[0])
    linear = 1 + SHARED * shared
    nearly = (seen.almost[rule] + FEW_SITES) / (seen.almost_control[rule] + FEW_SITES)
    return float(max(linear, nearly ** (seen.frames / (seen.frames - 1))))


def memory(e: ViewEvidence) -> list[FilterTest]:
    """Do pixels remember the frame before?"""
    if e.memory is None or not e.usable:
        return []
    m = e.memory
    return [
        FilterTest(
            "temporal_autocorrelation",
            "temporal_denoise",
            e,
            m.p,
            min(m.everywhere, m.without_trend),
            0.03,
            f"the lag-1 autocorrelation over {m.frames} frames exceeds that of all pairs of "
            f"frames by {minus(f'{m.excess:.3f}')}: a recursive filter with a share of "
            f"{100 * m.memory:.0f} %",
            m.memory,
        )
    ]


def row_phases(e: ViewEvidence) -> list[FilterTest]:
    """Are some rows, at a period, smoother than the rest?

    Not asked of one frame's fixed pattern: colours of other offsets lie in other rows.
    """
    r = e.rows
    if r is None or not e.usable or not e.temporal:
        return []
    p = min(1.0, r.p * max(r.tried, 1))
    return [
        FilterTest(
            "row_phase",
            "dpc" if r.one_sided else "denoise",
            e,
            p,
            r.effect,
            0.03,
            f"row {r.phase} of every {r.period} rows has {100 * r.effect:.1f} % fewer local "
            "extremes than the others",
            r.period,
        )
    ]
