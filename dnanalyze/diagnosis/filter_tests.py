"""Tests for filters applied to candidates, so that `detect` and `refine` agree."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import suppress
from functools import partial

from dnanalyze.detection.detect import detect
from dnanalyze.diagnosis.selection import EVIDENCE_NULL, Trial, significant
from dnanalyze.errors import InputError
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.loaders.captures import CaptureSet
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

FILTERS = ("dpc", "denoise", "temporal_denoise")
DENIED = "the tests of `detect` find no sign of a filter in these captures"


def denied(problem: FitProblem, model: NoiseModel, needed: bool) -> bool:
    """Whether the tests for filters reject a candidate filter.

    They find no mark of filtering in the captures, and either they must (``needed``), or they find
    it in the frames of the model with the filter: captures that could not show it do not deny it.
    """
    if problem.predictions.get("filtered", partial(_filtered, problem.plan.captures)) != _NO:
        return False
    if needed:
        return True
    plan = problem.plan
    made = simulate(model.in_codes, plan.shape, plan.settings, "simulation", plan.captures.sensor)
    return _filtered(made) == _YES


def without_denied(
    problem: FitProblem, leader: Trial, trials: Sequence[Trial], contenders: Collection[str]
) -> set[str]:
    """The contenders without filters that would be denied beside the leader in any form.

    Their forms cost as much as those of all others together. ``leader``: the best of ``trials``;
    beside one that is a filter, or not significant, none is denied.
    """
    filters = [t for t in trials if t.effect in FILTERS and t.effect in contenders]
    if leader.effect in FILTERS or not significant(leader, EVIDENCE_NULL):
        return set(contenders)
    return set(contenders) - {
        t.effect for t in filters if denied(problem, t.state.model, needed=True)
    }


_YES, _NO, _UNTESTED = "yes", "no", "untested"


def _filtered(captures: CaptureSet) -> str:
    with suppress(InputError):
        return _YES if detect(captures).filtered else _NO
    return _UNTESTED
