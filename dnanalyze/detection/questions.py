"""Tests to findings: each question with its null, its effect size and the effect that nature can
mimic.

A question is put to every view of every group. It is flagged only where its p-value survives Holm's
correction over all questions of the capture set *and* its effect exceeds what unfiltered
sensors show (``Asked.limit``): at a million pixels everything is significant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats

from dnanalyze.detection.correlation import largest_crosstalk, shot_share
from dnanalyze.detection.evidence import ViewEvidence
from dnanalyze.detection.excess import Excess, StandingOut
from dnanalyze.detection.replaced import RULES, Replaced

CLUSTERED = 0.2  # share of hot pixels that still stand out where most come in clusters
HIGHEST_THRESHOLD = 64.0  # in units of the noise
ABRUPT = 8.0  # a threshold empties the tail at once: this much from half the bound to the bound
ASKED_SLOPES = (2.0, 4.0)
GRADUAL = 4.0  # where the tail was thin at half the bound, no less than this part of it is expected
WHOLE = 0.5  # of the tail is left at half the bound
LEAST_SITES = 6.0  # expected pixels beyond a bound, a frame, below which it is not asked
LEAST_REPLACED = 8
SHARED = 40.0  # hum and 1/f noise, shared with neighbours, let more sites match by chance
UNSHARED = 0.02  # correlation of neighbours' noise below which none is
FEW_SITES = 5.0
APART = {"frame": 1, "planes": 2}  # pixels between the neighbours of a view


@dataclass(frozen=True)
class Asked:
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


def smoothing(e: ViewEvidence, others: list[tuple[float, float | None]]) -> list[Asked]:
    """Has the noise been smoothed beyond what charge crosstalk can do to shot noise?"""
    if not e.usable:
        return []
    bound = largest_crosstalk(APART[e.view])
    share = shot_share(e.correlation.variance, e.point.temperature_c, others) if e.temporal else 1.0
    room = 1.1 * share
    (bend, bend_se), lag = e.spectrum.concavity(), e.correlation
    shared = lag.short_range_under_flicker if e.temporal else lag.short_range
    extra = 0.0 if e.temporal else 0.02  # the fixed pattern of one frame is less exchangeable
    asked = [
        Asked(
            "spectral_corner",
            "denoise",
            e,
            one_sided(bend, bend_se),
            bend,
            0.08 + 2 * extra + room * bound.concavity,
            f"the noise spectrum is flat at low, falling at high frequencies, by {bend:.2f} "
            "in ln P below a straight line: 1/f noise only ever bends the other way",
        ),
        Asked(
            "crosstalk_or_denoise",
            "denoise",
            e,
            one_sided(shared, lag.short_range_error),
            shared,
            0.02 + extra + room * bound.short_range,
            f"neighbours' noise correlates by {max(lag.along_rows[0], 0):.3f} along rows and "
            f"{max(lag.along_columns[0], 0):.3f} along columns; crosstalk, which cannot touch read "
            f"noise, could give at most {share * bound.short_range:.3f} here",
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
        Asked(
            "median_equality",
            "denoise",
            e,
            one_sided(own - far, se),
            repeat,
            0.14,
            f"{own:.1%} of pixels equal their right neighbour exactly, {far:.1%} one farther away; "
            "a 3x3 median gives 21 %",
        )
    )
    return asked


def _backed(e: ViewEvidence, backed: bool, rarer_limit: float) -> list[Asked]:
    """Tests that tell the kind of a filter but never speak alone.

    Hum and strong 1/f noise make local extremes rarer, hits and clusters make noise uneven.
    """
    rank, t = e.rank[8], e.texture
    rarer, uneven = 1 - rank.extremes, t.dispersion - 1
    return [
        Asked(
            "rank_exceedance",
            "denoise",
            e,
            one_sided(rarer, rank.se),
            rarer,
            rarer_limit if backed else np.inf,
            f"local extremes of the noise are {rarer:.1%} rarer than among exchangeable pixels",
        ),
        Asked(
            "local_variance",
            "denoise",
            e,
            one_sided(uneven, t.dispersion_se),
            uneven,
            0.3 if backed else np.inf,
            "the noise is smooth here and rough there: 4x4 variances scatter "
            f"{t.dispersion:.2f} times as much as of independent pixels",
        ),
        Asked(
            "wavelet_kurtosis",
            "denoise",
            e,
            one_sided(t.hh_excess, t.hh_se),
            t.hh_excess,
            0.3 if backed else np.inf,
            f"the finest diagonal wavelet band has kurtosis {t.hh_kurtosis:.1f}, "
            f"{t.hh_excess:.1f} above that of independent pixels",
        ),
    ]


def standing_out(e: ViewEvidence) -> list[Asked]:
    """Does something keep pixels from standing out of their neighbours?"""
    asked = []
    for out in (e.above8, e.above24):
        asked.append(_cap(e, out))
        asked.append(_cliff(e, out, out.difference, "dynamic_threshold"))
        asked.append(_cliff(e, out, out.ratio, "ratio_rule"))
        asked.append(_slope(e, out))
    return [a for a in asked if a is not None]


def _cap(e: ViewEvidence, out: StandingOut) -> Asked | None:
    top, count = out.difference, out.neighbours
    control = float(top.control[0]) / top.frames
    own = float(top.own[0]) / top.frames
    if control < 20:
        return None
    return Asked(
        "cap_to_neighbours", "dpc", e, float(_fewer(np.array(own), np.array(control))),
        1 - own / control, 0.9,
        f"{own:.0f} pixels a frame stand above the largest of their {count} neighbours where "
        f"{control:.0f} stand above rings elsewhere: values are capped to the neighbours'",
        0.0, count,
    )  # fmt: skip


def _cliff(e: ViewEvidence, out: StandingOut, top: Excess, test: str) -> Asked | None:
    control, own = top.control / top.frames, top.own / top.frames
    enough = control >= LEAST_SITES
    if test == "dynamic_threshold":  # beyond, saturated charge spills over and hides the difference
        enough &= top.bounds <= HIGHEST_THRESHOLD * e.noise
    if not enough.any():
        return None
    at_half = _left(top)[_half(top)]
    expected = np.minimum(CLUSTERED, at_half / GRADUAL) * control
    p = np.where(enough & _abrupt(top), stats.poisson.cdf(np.floor(own), expected), 1.0)
    j = int(np.argmin(p + 1e-9 * np.arange(p.size)))
    below = float(own[j] / control[j])
    unit = "DN above" if test == "dynamic_threshold" else "times"
    return Asked(
        test, "dpc", e, min(1.0, float(p[j]) * 8), 1 - below, 0.97,
        f"{own[j]:.1f} pixels a frame stand more than {top.bounds[j]:.3g} {unit} the largest of "
        f"their {out.neighbours} neighbours, {control[j]:.0f} were expected from rings elsewhere",
        edge(top, j), out.neighbours,
    )  # fmt: skip


def _slope(e: ViewEvidence, out: StandingOut) -> Asked | None:
    """Rules of a ratio and a threshold together: 2 times the largest of 24 plus 400, say.

    A corrector replaces a pixel but not its fainter hot neighbour, which then stands alone; so
    something is left beyond the bound, and the tail at half of it is what it is held against. Hits
    span pixels and would thin the tail likewise: asked only where they are taken out.
    """
    best: Asked | None = None
    for a in ASKED_SLOPES if e.frames >= 3 else ():
        top = out.along(a)
        control, own = top.control / top.frames, top.own / top.frames
        left = own / np.maximum(control, 1e-9)
        half = left[np.searchsorted(top.bounds, top.bounds / 2)]
        fit = (control >= LEAST_SITES) & (half > WHOLE) & (top.bounds >= 8 * e.noise)
        fit &= top.bounds <= HIGHEST_THRESHOLD * e.noise
        whole = np.minimum(half, 1.0)
        p = np.where(fit, stats.poisson.cdf(np.floor(own), 0.5 * whole * control), 1.0)
        j = int(np.argmin(p + 1e-9 * np.arange(p.size)))
        found = Asked(
            "ratio_and_threshold", "dpc", e, min(1.0, float(p[j]) * 8 * len(ASKED_SLOPES)),
            1 - float(left[j] / whole[j]) if fit[j] else 0.0, 0.75,
            f"{own[j]:.1f} pixels a frame stand more than {top.bounds[j]:.3g} DN above {a:g} times "
            f"the largest of their {out.neighbours} neighbours, {control[j]:.0f} were expected "
            "from rings elsewhere",
            edge(top, j), out.neighbours, a,
        )  # fmt: skip
        if best is None or found.p < best.p:
            best = found
    return best


def _abrupt(top: Excess) -> np.ndarray:
    """Where the tail that is whole at half the bound (half the ratio above 1) is gone at the bound.

    Clusters of hot pixels thin it out as well, but gradually.
    """
    left = _left(top)
    return left[_half(top)] > ABRUPT * left


def _left(top: Excess) -> np.ndarray:
    return top.own / np.maximum(top.control, 1e-9)


def _half(top: Excess) -> np.ndarray:
    """Index of half of each bound, of half of each ratio above 1."""
    zero = 1.0 if top.bounds[0] >= 1 else 0.0
    return np.searchsorted(top.bounds, zero + (top.bounds - zero) / 2)


def edge(top: Excess, j: int) -> float:
    """The smallest bound beyond which (almost) nothing is left, from the ``j``-th down."""
    empty = top.own <= 0.02 * top.control
    while j > 0 and empty[j - 1] and top.control[j - 1] > 0:
        j -= 1
    return float(top.bounds[j])


def _fewer(own: np.ndarray, control: np.ndarray) -> np.ndarray:
    """Poisson P(n <= own) where clusters leave only a part of the control standing out."""
    return np.asarray(stats.poisson.cdf(np.floor(own), CLUSTERED * control))


def sites(e: ViewEvidence) -> list[Asked]:
    """Are there sites that are always what their neighbours say, here or at all settings?"""
    asked = []
    if e.replaced is not None and e.replaced.tried:
        asked.append(_always(e, e.replaced, f"in all {e.replaced.frames} frames"))
    if e.listed is not None and e.listed.tried:
        where = f"in {e.listed.frames} frames, whatever the setting,"
        asked.append(_always(e, e.listed, where))
    return asked


def _always(e: ViewEvidence, seen: Replaced, where: str) -> Asked:
    own, control = seen.own, seen.control
    p = stats.poisson.sf(own - 1, 3 * control + 1)
    j = int(np.argmax(own / (control + 3)))
    found = int(own[j])
    return Asked(
        "static_replacement",
        "dpc",
        e,
        min(1.0, float(p[j]) * len(RULES)),
        float(found / (control[j] + 1)) if found >= LEAST_REPLACED else 0.0,
        5.0 * _by_chance(e, seen, j),
        f"{found} sites are {where} the {RULES[j]} of their neighbours, {control[j]:.0f} of a ring "
        "elsewhere",
        j,
        sites=seen,
    )


def _by_chance(e: ViewEvidence, seen: Replaced, rule: int) -> float:
    """How many times as many sites as in the control match because neighbours share noise.

    Sites that match in all K frames but one do so by chance: theirs to the power K / (K - 1).
    """
    shared = max(0.0, e.correlation.along_rows[0], e.correlation.along_columns[0])
    linear = 1 + SHARED * shared
    if shared < UNSHARED:
        return linear
    nearly = (seen.almost[rule] + FEW_SITES) / (seen.almost_control[rule] + FEW_SITES)
    return float(max(linear, nearly ** (seen.frames / (seen.frames - 1))))


def memory(e: ViewEvidence) -> list[Asked]:
    """Do pixels remember the frame before?"""
    if e.memory is None or not e.usable:
        return []
    m = e.memory
    return [
        Asked(
            "temporal_autocorrelation",
            "temporal_denoise",
            e,
            m.p,
            min(m.everywhere, m.without_trend),
            0.03,
            f"lag-1 autocorrelation over {m.frames} frames is {m.excess:+.3f} above that of "
            f"frames in any order: a recursive memory of {m.memory:.0%}",
            m.memory,
        )
    ]


def row_phases(e: ViewEvidence) -> list[Asked]:
    """Are some rows, at a period, smoother than the rest?

    Not asked of one frame's fixed pattern: colours of other offsets lie in other rows.
    """
    r = e.rows
    if r is None or not e.usable or not e.temporal:
        return []
    p = min(1.0, one_sided(r.z, 1.0) * max(r.tried, 1))
    return [
        Asked(
            "row_phase",
            "dpc" if r.one_sided else "denoise",
            e,
            p,
            r.effect,
            0.03,
            f"rows {r.phase} of every {r.period} have {r.effect:.1%} fewer local extremes "
            "than the others",
            r.period,
        )
    ]
