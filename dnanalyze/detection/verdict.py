"""One verdict from all findings, and why a finding does not count.

By Holm's correction, by what nature can mimic, and by the agreement between tests.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from dnanalyze.detection import tests
from dnanalyze.detection.evidence import ViewEvidence
from dnanalyze.detection.results import Finding
from dnanalyze.detection.tests import BACKED, LIMITS
from dnanalyze.digits import number
from dnanalyze.significance import NOTICEABLE

ROUND = 0.15  # correlation of next neighbours of a colour beyond that of farther ones
SLIGHT = 5.0  # times the limit: replacing a few per cent of pixels does less to the noise
FEW_CLIPPED = 0.005  # share of pixels that does not change the variance
NOT_SIGNIFICANT = "not significant after Holm's correction"
KINDS = {
    "dpc": "defect-pixel correction",
    "denoise": "spatial denoise",
    "temporal_denoise": "temporal denoise",
}


def ask(evidence: list[ViewEvidence], alpha: float) -> list[Finding]:
    """Put every question to every view, and correct for their number.

    None to settings most of whose pixels are clipped or saturated.
    """
    evidence = [e for e in evidence if not e.full]
    coloured = [e.point for e in evidence if e.view == "frame" and _coloured(e)]
    unfit = {id(e) for e in evidence if e.point in coloured and not _round(e)}
    judges = _quietest(evidence) - unfit
    asked: list[Finding] = []
    for e in evidence:
        like = replace(e.point, temperature_c=None)
        others = [
            (o.correlation.variance, o.point.temperature_c)
            for o in evidence
            if o.view == e.view
            and o.clipped < FEW_CLIPPED
            and replace(o.point, temperature_c=None) == like
        ]
        of_noise = tests.smoothing(e, others) + tests.row_phases(e)
        asked += [replace(f, counts=id(e) in judges) for f in of_noise]
        asked += tests.standing_out(e) + tests.sites(e) + tests.memory(e)
    return [
        replace(f, holm=p, flagged=f.counts and p < alpha and f.effect_size > f.limit)
        for f, p in zip(asked, holm(np.array([f.p_value for f in asked])).tolist(), strict=True)
    ]


def _coloured(e: ViewEvidence) -> bool:
    """Noise that grows towards high frequencies: interference of the readout.

    No filter makes that, and sampled every second pixel it looks like smoothing.
    """
    ratio, se = e.spectrum.suppression
    return bool(np.isfinite(ratio) and ratio > LIMITS["spectral_corner"] + NOTICEABLE * se)


def _round(e: ViewEvidence) -> bool:
    """Smooth within a colour in both directions: interference follows the scan, filters do not."""
    return e.view == "planes" and e.correlation.short_range > ROUND


def holm(p: np.ndarray) -> np.ndarray:
    """Holm's step-down adjusted p-values."""
    order = np.argsort(p)
    steps = np.minimum(p[order] * np.arange(p.size, 0, -1), 1.0)
    adjusted = np.empty_like(p)
    adjusted[order] = np.maximum.accumulate(steps)
    return adjusted


def _quietest(evidence: list[ViewEvidence]) -> set[int]:
    """Where a denoise must show: the two quietest groups of each gain and channel.

    What warms up (shot noise under crosstalk, hits) is least there. Crosstalk does not reach from
    pixel to pixel of a colour: there every group counts. Where rounding hides
    everything the least rounded group is taken; single frames only where there are no repeats.
    """
    chosen: set[int] = set()
    sets: dict[tuple[object, ...], list[ViewEvidence]] = defaultdict(list)
    repeats = any(e.temporal and e.usable for e in evidence)
    for e in evidence:
        if e.usable and (e.temporal or not repeats):
            sets[(e.view, e.point.gain, e.point.channel)].append(e)
    for members in sets.values():
        members.sort(key=lambda e: e.correlation.variance)
        fine = [e for e in members if e.fine]
        most = 1 if not repeats else len(fine) if members[0].view == "planes" else 2
        chosen |= {id(e) for e in fine[:most] or members[-1:]}
    return chosen


def decide(findings: Sequence[Finding]) -> tuple[str, list[Finding]]:
    """The kind ("none" for no flag) and the flagged findings that speak for it."""
    flagged = [f for f in findings if f.flagged]
    corrected = [f for f in flagged if f.kind == "dpc"]
    smoothed = [f for f in flagged if f.kind == "denoise"]
    remembered = _memory(findings)
    capped, asked_cap = (_of(some, "cap_to_neighbours") for some in (flagged, findings))
    if capped and 4 * len(capped) >= len(asked_cap):
        return "dpc", corrected
    if smoothed and not (corrected and _explained(smoothed, corrected)):
        return "denoise", smoothed
    if corrected:
        return "dpc", corrected
    if remembered:
        return "temporal_denoise", remembered
    return "none", []


def _of(findings: Sequence[Finding], test: str) -> list[Finding]:
    return [f for f in findings if f.test == test]


def _memory(findings: Sequence[Finding]) -> list[Finding]:
    """Flags of at least half of the settings in which rounding could not hide a memory."""
    able = [
        f for f in _of(findings, "temporal_autocorrelation")
        if f.flagged or f.evidence.fine
    ]  # fmt: skip
    flagged = [f for f in able if f.flagged]
    return flagged if 2 * len(flagged) >= max(1, len(able)) else []


def _explained(smoothed: list[Finding], corrected: list[Finding]) -> bool:
    """The correction alone makes the noise look smoothed: it touched hot pixels alone, or its sites
    are plain and the smoothing is slight, as where a low threshold replaces a few per cent.
    """
    slight = all(f.effect_size < SLIGHT * LIMITS[f.test] for f in smoothed if f.test not in BACKED)
    plain = max((f.score for f in _of(corrected, "static_replacement")), default=0.0) > 2
    return _only_maxima(smoothed + corrected) or (slight and plain)


def _only_maxima(findings: list[Finding]) -> bool:
    """Maxima of the frames as recorded are rarer and minima are not: hot pixels alone were
    touched.
    """
    seen = {id(f.evidence): f.evidence.recorded for f in findings}
    up = np.mean([1 - 9 * r.above / r.pixels for r in seen.values()])
    down = np.mean([1 - 9 * r.below / r.pixels for r in seen.values()])
    return bool(up > 0.01 and down < 0.4 * up)


def settled(
    findings: Sequence[Finding], kind: str, flags: Sequence[Finding], also: Sequence[str],
    alpha: float,
) -> tuple[Finding, ...]:  # fmt: skip
    """Findings flagged where the verdict rests on them, the others with the reason why not.

    ``flags``: those on which a verdict of this ``kind`` rests; ``also``: further kinds of which
    there are signs.
    """
    speaks = {id(f) for f in flags}
    return tuple(
        replace(f, flagged=True) if id(f) in speaks
        else replace(f, flagged=False, reason=_reason(f, kind, also, alpha))
        for f in findings
    )  # fmt: skip


def _reason(f: Finding, kind: str, also: Sequence[str], alpha: float) -> str:
    if not f.holm < alpha:
        return NOT_SIGNIFICANT
    if not f.counts:
        return "not used here: crosstalk or quantization can cause it; only the lowest noise counts"
    if not math.isfinite(f.limit):
        return "not sufficient alone: periodic noise, particle hits or clusters can cause it"
    if not f.effect_size > f.limit:
        return f"effect size up to {number(f.limit, 2)} occurs in unfiltered sensors"
    if kind in (f.kind, "none"):
        return "too few operating points agree"
    if f.kind in also:
        return f"indicates {KINDS[f.kind]} as well"
    return f"explained by the {KINDS[kind]}"
