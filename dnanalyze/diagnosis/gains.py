"""Gain of a refit on either half, by one simulated sensor or by the predictive distribution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dnanalyze.comparator.error import pooled
from dnanalyze.comparator.predictive_check import FittedModel, Halves
from dnanalyze.diagnosis.selection import Trial, falls, overdispersion
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State, deviance
from dnanalyze.model.effect import Effect


def trial_of(null: FittedModel, effect: str, after: State) -> Trial:
    """A refit, with what its own simulated sensor gained on either half."""
    was, now = (((s.train, np.ones(1)), (s.test, np.ones(1))) for s in (null.state, after))
    return _compared(null.problem, effect, after, was, now)


def trial_by_prediction(null: FittedModel, found: Trial) -> Trial:
    """A refit, with what the predictive distribution of its design gained on either half.

    Each model by the mean of nine sensors of its design and by the standard deviation of another
    about it (synthetic likelihood, Wood 2010): where the defects of one simulated sensor happen to
    lie is not to decide, and what varies from sensor to sensor is not to count as a misfit.
    """
    now = FittedModel(null.problem, found.state).predictive
    made = _compared(null.problem, found.effect, found.state, null.predictive, now)
    return replace(made, others=found.others, formed=found.formed)


def _compared(problem: FitProblem, effect: str, after: State, was: Halves, now: Halves) -> Trial:
    """Gains in twice the logarithm of the density of what was measured."""
    halves = list(zip((problem.train.names, problem.test.names), was, now, strict=True))
    fitted, unseen = [(of, z / sd, z_now / sd_now) for of, (z, sd), (z_now, sd_now) in halves]
    wider = [2.0 * np.log(sd_now / sd) for _, (_, sd), (_, sd_now) in halves]
    added = after.model.get(effect)
    fitted_gain, gain = (
        _in_time(problem, added, half.setting, deviance(z) - deviance(z_now) - more)
        for half, (_, z, z_now), more in zip(
            (problem.train, problem.test), (fitted, unseen), wider, strict=True
        )
    )
    families = problem.test.families
    error_was, error_now = (pooled(z, families) for z in unseen[1:])
    return Trial(
        effect,
        after,
        *_witnessed(problem, added, gain, fitted_gain),
        pooled(after.test, families),
        error_was - error_now,
        overdispersion(*unseen),
        falls=np.concatenate([falls(*unseen), falls(*fitted)]),
    )


def _in_time(
    problem: FitProblem, effect: Effect | None, setting: np.ndarray, gains: np.ndarray
) -> float:
    """Sum of the gains of the statistics; ``setting``: number of the operating point of each.

    A fixed pattern shows in a single frame what an effect does that is new in every frame. Where
    some operating points have several frames, the others are evidence against such an effect only.
    """
    several = np.array([count > 1 for _, count in problem.plan.settings])[setting]
    if effect is None or effect.varies != "temporal" or not several.any():
        return float(np.sum(gains))
    return float(np.sum(gains[several])) + min(0.0, float(np.sum(gains[~several])))


def _witnessed(
    problem: FitProblem, effect: Effect | None, gain: float, fitted_gain: float
) -> tuple[float, float]:
    """Gains on the held-out and on the fitted half, of an effect that lies in one of them alone.

    The half without it is evidence against it only.
    """
    if effect is None:
        return gain, fitted_gain
    upper, lower = map(effect.lies_in, problem.plan.windows)
    if upper == lower:
        return gain, fitted_gain
    there, elsewhere = (gain, fitted_gain) if lower else (fitted_gain, gain)
    return (there + min(0.0, elsewhere),) * 2
