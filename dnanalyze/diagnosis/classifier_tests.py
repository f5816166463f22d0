"""Classifier tests of candidates that explain the same statistics equally well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from dnanalyze.classifier.classify import classify_on
from dnanalyze.diagnosis.baseline import far_off
from dnanalyze.diagnosis.selection import EVIDENCE_NULL, Trial, competitors, significant
from dnanalyze.fitting.problem import FitProblem

DISTINGUISHED = (
    "a classifier tells the simulated frames from the measured ones with this effect added"
)
POINTS = 2  # far apart in temperature and exposure: two fifths of the time of all five


def without_distinguished(problem: FitProblem, ranked: Sequence[Trial]) -> list[Trial]:
    """The trials without competitors whose frames a classifier distinguishes.

    Only where the frames of one of them are not distinguished, and not while the model is far off:
    the frames of all candidates then differ by what else is missing.
    """
    alike = _competing(ranked)
    if len(alike) < 2 or far_off(alike[0].state):
        return list(ranked)
    distinguished = [t for t in alike if _distinguishes(problem, t)]
    if len(distinguished) == len(alike):
        return list(ranked)
    return [replace(t, denied=DISTINGUISHED) if t in distinguished else t for t in ranked]


def _competing(ranked: Sequence[Trial]) -> list[Trial]:
    """The first candidate and its competitors, where it is significant."""
    if not ranked or not significant(ranked[0], EVIDENCE_NULL):
        return []
    near = competitors(ranked[0], ranked)
    return [ranked[0], *(t for t in ranked[1:] if t.effect in near and not t.denied)]


def _distinguishes(problem: FitProblem, found: Trial) -> bool:
    model, captures = found.state.model, problem.plan.captures
    return classify_on(
        captures,
        model,
        seed=model.seed,
        points=POINTS,
        limit=problem.limit,
        helpers=problem.helpers,
    ).tells
