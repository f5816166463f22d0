"""Classifier tests of candidates that explain the same statistics equally well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from dnanalyze.classifier.classify import classify_on
from dnanalyze.diagnosis.baseline import far_off
from dnanalyze.diagnosis.selection import EVIDENCE_NULL, Trial, competitors, significant
from dnanalyze.fitting.problem import FitProblem

TOLD = "a classifier tells the simulated frames from the measured ones with this effect added"
POINTS = 2  # far apart in temperature and exposure: two fifths of the time of all five


def told_apart(problem: FitProblem, ranked: Sequence[Trial]) -> list[Trial]:
    """The trials without competitors whose frames a classifier distinguishes.

    That is done only where the frames of one of them cannot be told. It is not asked while the
    model is far off: the frames of all candidates are then told by what else is missing.
    """
    alike = _competing(ranked)
    if len(alike) < 2 or far_off(alike[0].state):
        return list(ranked)
    told = [t for t in alike if _tells(problem, t)]
    if len(told) == len(alike):
        return list(ranked)
    return [replace(t, denied=TOLD) if t in told else t for t in ranked]


def _competing(ranked: Sequence[Trial]) -> list[Trial]:
    """The first candidate and its competitors, where it is significant."""
    if not ranked or not significant(ranked[0], EVIDENCE_NULL):
        return []
    near = competitors(ranked[0], ranked)
    return [ranked[0], *(t for t in ranked[1:] if t.effect in near and not t.denied)]


def _tells(problem: FitProblem, found: Trial) -> bool:
    model, captures = found.state.model, problem.plan.captures
    return classify_on(
        captures,
        model,
        seed=model.seed,
        points=POINTS,
        limit=problem.limit,
        helpers=problem.helpers,
    ).tells
