"""One verdict from all answers, and why an answer does not count.

By Holm's correction, by what nature can mimic, and by the agreement between tests.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.detection import tests
from dnanalyze.detection.evidence import ViewEvidence
from dnanalyze.detection.tests import FilterTest
from dnanalyze.digits import number
from dnanalyze.loaders.captures import OperatingPoint

FINE = 0.75  # noise over step from which rounding no longer hides a filter
ROUND = 0.15  # correlation of next neighbours of a colour beyond that of farther ones
# What replacing a few per cent of pixels does to the noise stays below these.
SLIGHT = {
    "spectral_corner": 0.4, "crosstalk_or_denoise": 0.1, "median_equality": 0.28, "row_phase": 0.06,
}  # fmt: skip
NOT_SIGNIFICANT = "not significant after Holm's correction"
KINDS = {
    "dpc": "defect-pixel correction",
    "denoise": "spatial denoise",
    "temporal_denoise": "temporal denoise",
}
CAUSES = (
    "cap_to_neighbours", "dynamic_threshold", "ratio_rule", "ratio_and_threshold",
    "static_replacement",
)  # fmt: skip


@dataclass(frozen=True)
class TestResult:
    """A question with its corrected p-value.

    Parameters
    ----------
    asked : FilterTest
    holm : float
        p-value after Holm's correction over all tests.
    flagged : bool
    judge : bool
        FilterTest where its answer counts; elsewhere it is given for information.
    """

    asked: FilterTest
    holm: float
    flagged: bool
    judge: bool = True


def ask(evidence: list[ViewEvidence], alpha: float) -> list[TestResult]:
    """Put every question to every view, and correct for their number.

    None to settings most of whose pixels are clipped or saturated.
    """
    evidence = [e for e in evidence if not e.full]
    coloured = _coloured(evidence)
    unfit = {id(e) for e in evidence if e.point in coloured and not _round(e)}
    judges = _quietest(evidence) - unfit
    asked: list[tuple[FilterTest, bool]] = []
    for e in evidence:
        warmer = [
            (o.correlation.variance, o.point.temperature_c)
            for o in evidence
            if o.view == e.view and o.clipped < 0.005 and replace(o.point, temperature_c=None)
            == replace(e.point, temperature_c=None)
        ]  # fmt: skip
        asked += [(a, id(e) in judges) for a in tests.smoothing(e, warmer)]
        rest = tests.standing_out(e) + tests.sites(e) + tests.memory(e)
        asked += [(a, True) for a in rest]
        asked += [(a, id(e) in judges) for a in tests.row_phases(e)]
    adjusted = holm(np.array([a.p for a, _ in asked]))
    return [
        TestResult(a, float(p), bool(judge and p < alpha and a.effect > a.limit), judge)
        for (a, judge), p in zip(asked, adjusted, strict=True)
    ]


def _coloured(evidence: list[ViewEvidence]) -> set[OperatingPoint]:
    """Settings whose noise grows towards high frequencies: interference of the readout.

    No filter makes that, and sampled every second pixel it looks like smoothing.
    """
    points = set()
    for e in evidence:
        ratio, se = e.spectrum.suppression
        if e.view == "frame" and np.isfinite(ratio) and ratio > 0.1 + 4 * se:
            points.add(e.point)
    return points


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
        fine = [e for e in members if e.noise >= FINE * e.step]
        most = 1 if not repeats else len(fine) if members[0].view == "planes" else 2
        chosen |= {id(e) for e in fine[:most] or members[-1:]}
    return chosen


def decide(answers: list[TestResult]) -> tuple[str, list[TestResult]]:
    """The kind ("none" for no flag) and the flagged answers that speak for it."""
    flagged = [a for a in answers if a.flagged]
    capped = _of(flagged, "cap_to_neighbours")
    corrected = [a for a in flagged if a.asked.kind == "dpc"]
    smoothed = [a for a in flagged if a.asked.kind == "denoise"]
    remembered = _memory(answers)
    asked_cap = [a for a in answers if a.asked.test == "cap_to_neighbours"]
    if capped and 4 * len(capped) >= len(asked_cap):
        return "dpc", corrected
    if smoothed and not (corrected and _explained(smoothed, corrected)):
        return "denoise", smoothed
    if corrected:
        return "dpc", corrected
    if remembered:
        return "temporal_denoise", remembered
    return "none", []


def _of(answers: list[TestResult], *tests: str) -> list[TestResult]:
    return [a for a in answers if a.asked.test in tests]


def _memory(answers: list[TestResult]) -> list[TestResult]:
    """Flags of at least half of the settings in which rounding could not hide a memory."""
    able = [
        a for a in _of(answers, "temporal_autocorrelation")
        if a.asked.evidence.noise >= 1.2 * a.asked.evidence.step or a.flagged
    ]  # fmt: skip
    flagged = [a for a in able if a.flagged]
    return flagged if 2 * len(flagged) >= max(1, len(able)) else []


def _explained(smoothed: list[TestResult], corrected: list[TestResult]) -> bool:
    """The correction alone makes the noise look smoothed: it touched hot pixels alone, or its sites
    are plain and the smoothing is slight, as where a low threshold replaces a few per cent.
    """
    slight = all(a.asked.effect < SLIGHT.get(a.asked.test, np.inf) for a in smoothed)
    plain = max((_score(a) for a in _of(corrected, "static_replacement")), default=0.0) > 2
    return _only_maxima(smoothed + corrected) or (slight and plain)


def _score(answer: TestResult) -> float:
    return answer.asked.effect / answer.asked.limit


def _only_maxima(answers: list[TestResult]) -> bool:
    """Maxima of the frames as recorded are rarer and minima are not: hot pixels alone were
    touched.
    """
    seen = {id(a.asked.evidence): a.asked.evidence.recorded for a in answers}
    up = np.mean([1 - 9 * r.above / r.pixels for r in seen.values()])
    down = np.mean([1 - 9 * r.below / r.pixels for r in seen.values()])
    return bool(up > 0.01 and down < 0.4 * up)


def reason(answer: TestResult, kind: str, speaks: bool, also: tuple[str, ...], alpha: float) -> str:
    """Why an answer does not count; empty for one that speaks for the verdict.

    Parameters
    ----------
    answer : TestResult
    kind : str
        Of the verdict.
    speaks : bool
        It is one of the answers that the verdict rests on.
    also : tuple of str
        Further kinds of which there are signs.
    alpha : float
        Chance of a false alarm over all questions.
    """
    asked = answer.asked
    if speaks:
        return ""
    if not answer.holm < alpha:
        return NOT_SIGNIFICANT
    if not answer.judge:
        return "not used here: crosstalk or quantization can cause it; only the lowest noise counts"
    if not math.isfinite(asked.limit):
        return "not sufficient alone: periodic noise, particle hits or clusters can cause it"
    if not asked.effect > asked.limit:
        return f"effect size up to {number(asked.limit, 2)} occurs in unfiltered sensors"
    if kind in (asked.kind, "none"):
        return "too few operating points agree"
    if asked.kind in also:
        return f"indicates {KINDS[asked.kind]} as well"
    return f"explained by the {KINDS[kind]}"
