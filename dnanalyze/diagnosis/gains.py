"""What a refit gains on either half: by one simulated sensor, or by what its make shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from dnanalyze.comparator.error import pooled
from dnanalyze.diagnosis.predictive_check import Null
from dnanalyze.diagnosis.selection import Trial, falls, overdispersion
from dnanalyze.fitting.least_squares import State, deviance
from dnanalyze.fitting.predictor import Bench
from dnanalyze.model.effect import Effect

Scaled = tuple[State, tuple[np.ndarray, np.ndarray]]  # with standard deviations of (train, test)


def judged(null: Null, effect: str, after: State, scale: Null | None = None) -> Trial:
    """A refit, with what its own simulated sensor gained on either half.

    ``scale``: the model whose replicates give the scatter; ``null`` by default.
    """
    sd = (scale or null).scatter
    return _compared(null.held, effect, (null.state, sd), (after, sd))


def judged_by_prediction(null: Null, found: Trial) -> Trial:
    """A refit, with what the predictive distribution of its make gained on either half.

    Each model by the mean of nine sensors of its make and by the standard deviation of another one
    about it (synthetic likelihood, Wood 2010): where the defects of one simulated sensor happen to
    lie is not to decide, and what varies from sensor to sensor is not to count as a misfit.
    """
    own = Null(null.held, found.state)
    before, after = (null.mean, null.predictive_sd), (own.mean, own.predictive_sd)
    made = _compared(null.held, found.effect, before, after)
    return replace(made, state=found.state, error=found.error, others=found.others)


def _compared(held: Bench, effect: str, before: Scaled, after: Scaled) -> Trial:
    """Gains in twice the logarithm of the density of what was measured."""
    gains, changes = [], []
    for half, side, n in ((held.test, "test", 1), (held.train, "train", 0)):
        (was, sd_was), (now, sd_now) = ((getattr(s, side), sd[n]) for s, sd in (before, after))
        change = half.names, was / sd_was, now / sd_now
        wider = 2.0 * np.log(sd_now / sd_was)
        gains.append(float(np.sum(deviance(change[1]) - deviance(change[2]) - wider)))
        changes.append(change)
    state, families = after[0], held.test.families
    error_was, error_is = (pooled(z, families) for z in changes[0][1:])
    return Trial(
        effect,
        state,
        *_witnessed(held, state.model.get(effect), *gains),
        pooled(state.test, families),
        error_was - error_is,
        overdispersion(*changes[0]),
        falls=np.concatenate([falls(*change) for change in changes]),
    )


def _witnessed(
    bench: Bench, effect: Effect | None, gain: float, fitted_gain: float
) -> tuple[float, float]:
    """Gains on the held-out and on the fitted half, of an effect that lies in one of them alone.

    The half without it is evidence against it only.
    """
    if effect is None:
        return gain, fitted_gain
    upper, lower = map(effect.lies_in, bench.plan.windows)
    if upper == lower:
        return gain, fitted_gain
    there, elsewhere = (gain, fitted_gain) if lower else (fitted_gain, gain)
    return (there + min(0.0, elsewhere),) * 2
