"""The yardstick of a comparison: what another sensor of the same design would differ by.

The standard error of a statistic comes from the measured frames (see
`dnanalyze.analyzers.estimators.uncertainty`). What a model places, such as a glow, makes no scatter
there only as far as it is smooth; what it draws once a sensor, such as a cloud or a few defects,
shows in one measured sensor as structure. Simulated sensors of the model tell both apart.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.stats import chi2

from dnanalyze.analyzers.catalogue import catalogue
from dnanalyze.analyzers.statistics import Scale
from dnanalyze.fitting.least_squares import State
from dnanalyze.fitting.predictor import Bench
from dnanalyze.fitting.vectors import Target
from dnanalyze.model.noise_model import NoiseModel

REPLICATES = 8  # their standard deviation is good to a quarter, 1 / sqrt(2 (8 - 1))
DENIED = 0.01  # chance below which a smaller scatter of the replicates replaces the stated error
LOWEST = 0.05  # of the stated error: values that all replicates share have no scatter to go by


def by_design(held: Bench, model: NoiseModel) -> Bench:
    """The captures by the yardstick of a model: what two sensors of its design differ by."""
    drawn = [held.replicate(model, r) for r in range(REPLICATES)]
    train, test = (np.array(half) for half in zip(*drawn, strict=True))
    return held.scaled(*scales(held.train, held.test, train, test))


def measured_by(held: Bench, state: State) -> tuple[Bench, State]:
    """The captures, and a fitted model's misfit, by the yardstick of that model.

    ``state`` is by the yardstick of ``held``.
    """
    there = by_design(held, state.model)
    return there, expressed(state, held, there)


def scales(
    fitted: Target, judged: Target, train: np.ndarray, test: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Factors of the stated reproducibility of each statistic.

    At a statistic and operating point, both halves together: the scatter of the replicates where
    the stated error is denied by it (chi-squared test), for then it holds structure that the design
    repeats. Counts have at least Poisson's scatter. Else at least 1, and as much as the replicates
    scatter over all operating points: few defects, tracks or phases are drawn once a sensor, and
    shift a statistic at all of them alike.

    Parameters
    ----------
    fitted, judged : Target
        The two halves.
    train, test : ndarray
        Coordinates of replicates on either, (replicates, statistics); NaN where one lacks it.
    """
    ratios = [_ratio(half, z) for half, z in ((fitted, train), (judged, test))]
    own = _together([k for half in (fitted, judged) for k in half.keys], ratios)
    by_name = _together(np.concatenate([fitted.names, judged.names]), ratios)
    freedom = 2 * (len(train) - 1)
    least = np.concatenate([_least(half) for half in (fitted, judged)])
    denied = own**2 < chi2.ppf(DENIED, freedom) / freedom
    found = np.where(denied, np.maximum(own, least), np.maximum(by_name, 1.0))
    return found[: len(fitted.keys)], found[len(fitted.keys) :]


def _ratio(half: Target, drawn: np.ndarray) -> np.ndarray:
    """Variance of a difference of two replicates over that stated; 1 where they do not tell."""
    seen = np.isfinite(drawn)
    count = seen.sum(axis=0)
    mean = np.where(seen, drawn, 0.0).sum(axis=0) / np.maximum(count, 1)
    square = np.where(seen, drawn - mean, 0.0) ** 2
    variance = 2.0 * square.sum(axis=0) / np.maximum(count - 1, 1)
    told = (count == len(drawn)) & (variance > 0.0)
    return np.where(told, variance / half.stated**2, 1.0)


def _together(labels: Iterable[object], ratios: list[np.ndarray]) -> np.ndarray:
    """Root of the mean of the ratios that have the same label."""
    _, which = np.unique([str(label) for label in labels], return_inverse=True)
    mean = np.bincount(which, np.concatenate(ratios)) / np.bincount(which)
    return np.asarray(np.sqrt(mean)[which])


def _least(half: Target) -> np.ndarray:
    """Smallest factor: of a count, what makes its error that of Poisson's law."""
    infos = catalogue()
    counts = np.array([infos[k.name].scale is Scale.ROOT for k in half.keys])
    return np.where(counts, np.minimum(np.sqrt(2.0) / half.stated, 1.0), LOWEST)


def expressed(state: State, there: Bench, here: Bench) -> State:
    """A state of one yardstick in another of the same statistics."""
    return replace(
        state,
        train=there.train.expressed(state.train, here.train),
        unseen=cache(lambda: there.test.expressed(state.test, here.test)),
        jacobian=state.jacobian * (there.train.floor / here.train.floor)[:, None],
        bounds=here.train.bounds,
    )
