"""Why a significant finding is no flag, in words."""

from __future__ import annotations

import math

from dnanalyze.detection.verdict import TestResult
from dnanalyze.digits import number

NOT_SIGNIFICANT = "not significant after Holm's correction"
KINDS = {
    "dpc": "defect-pixel correction",
    "denoise": "spatial denoise",
    "temporal_denoise": "temporal denoise",
}


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
