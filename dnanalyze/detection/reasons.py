"""Why a significant finding is no flag, in words."""

from __future__ import annotations

import math

from dnanalyze.detection.verdict import Answer

KINDS = {
    "dpc": "defect-pixel correction",
    "denoise": "spatial denoise",
    "temporal_denoise": "temporal denoise",
}


def reason(answer: Answer, kind: str, speaks: bool, also: tuple[str, ...], alpha: float) -> str:
    """Why an answer does not count; empty for one that speaks for the verdict.

    Parameters
    ----------
    answer : Answer
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
        return f"not significant among all questions (corrected p = {answer.holm:.2g})"
    if not answer.judge:
        return (
            "the test counts only at the quietest settings: here shot noise under crosstalk, "
            "rounding or interference of the readout can do this"
        )
    if not math.isfinite(asked.limit):
        return (
            "the test never speaks alone, since hum, hits or clusters move it, and no test that "
            "does is flagged with it"
        )
    if not asked.effect > asked.limit:
        return (
            f"the effect, {asked.effect:.2g}, is not above its limit, {asked.limit:.2g}, which "
            "unfiltered sensors reach"
        )
    if kind in (asked.kind, "none"):
        return "too few of the settings agree"
    if asked.kind in also:
        return f"it is a sign of {KINDS[asked.kind]}, beside the verdict"
    return f"the verdict, {KINDS.get(kind, kind)}, explains it"
