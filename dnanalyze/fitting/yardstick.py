"""The yardstick of a comparison: what another sensor of the same design would differ by.

The standard error of a statistic comes from the measured frames (see
`dnanalyze.analyzers.estimators.uncertainty`). What a model places, such as a glow, makes no scatter
there only as far as it is smooth; what it draws once a sensor, such as a cloud or a few defects,
shows in one measured sensor as structure. Simulated sensors of the model tell both apart.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.special import digamma, polygamma

from dnanalyze.fitting.least_squares import State
from dnanalyze.fitting.predictor import Bench
from dnanalyze.fitting.vectors import Target
from dnanalyze.model.noise_model import NoiseModel

REPLICATES = 8  # their standard deviation is good to a quarter, 1 / sqrt(2 (8 - 1))
# Of the stated error; on sensors without structure 98 % of the statistics scatter by more than half
# of it (benchmarks/yardstick.py), so that less is a mark of structure in the stated error.
CLEAR = 0.5
# Families of shares, extremes and counts of few pixels, lines or codes: their laws are skewed, and
# their stated errors grow with the value; a few replicates say nothing of a large one.
SKEWED = ("lines", "codes", "tails")
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

    Where the scatter of the replicates, both halves together, is clearly below the stated error,
    that holds structure which the design repeats: the scatter replaces it. Elsewhere the factor is
    at least 1, and as much as the replicates scatter over all operating points: few defects, tracks
    or phases are drawn once a sensor, and shift a statistic at all of them alike.

    Parameters
    ----------
    fitted, judged : Target
        The two halves.
    train, test : ndarray
        Coordinates of replicates on either, (replicates, statistics); NaN where one lacks it.
    """
    ratios = [_ratio(half, z) for half, z in ((fitted, train), (judged, test))]
    both = (fitted, judged)
    own = _together([str(k) for half in both for k in half.keys], ratios)
    by_name = _together(np.concatenate([half.names for half in both]), ratios)
    kinds = [f"{f} {s}" for h in both for f, s in zip(h.families, h.setting, strict=True)]
    likely = _shrunk(own, np.array(kinds), 2 * (len(train) - 1))
    least = np.concatenate([_least(half) for half in both])
    found = np.where(likely < CLEAR, np.maximum(likely, least), np.maximum(by_name, 1.0))
    return found[: len(fitted.keys)], found[len(fitted.keys) :]


def _shrunk(ratio: np.ndarray, kinds: np.ndarray, freedom: int) -> np.ndarray:
    """Ratios of standard deviations drawn to those of their kind (empirical Bayes).

    The logarithm of a sample's standard deviation has the variance psi'(n / 2) / 4 and the bias
    (psi(n / 2) - ln(n / 2)) / 2 at n degrees of freedom. What the ratios of a kind vary by beyond
    that is how far a statistic may differ from the others (Efron and Morris 1975); medians, since a
    few of them are skewed.
    """
    chance = float(polygamma(1, freedom / 2)) / 4.0
    bias = (float(digamma(freedom / 2)) - math.log(freedom / 2)) / 2.0
    logs = np.log(ratio) - bias
    found = np.empty_like(logs)
    for kind in np.unique(kinds):
        here = kinds == kind
        middle = float(np.median(logs[here]))
        spread = (1.4826 * float(np.median(np.abs(logs[here] - middle)))) ** 2
        real = max(spread - chance, 0.0)
        found[here] = middle + (logs[here] - middle) * real / (real + chance)
    return np.exp(found)


def _ratio(half: Target, drawn: np.ndarray) -> np.ndarray:
    """Variance of a difference of two replicates over that stated; 1 where they do not tell."""
    seen = np.isfinite(drawn)
    count = seen.sum(axis=0)
    mean = np.where(seen, drawn, 0.0).sum(axis=0) / np.maximum(count, 1)
    square = np.where(seen, drawn - mean, 0.0) ** 2
    variance = 2.0 * square.sum(axis=0) / np.maximum(count - 1, 1)
    told = (count == len(drawn)) & (variance > 0.0)
    return np.where(told, variance / half.stated**2, 1.0)


def _together(labels: Iterable[str], ratios: list[np.ndarray]) -> np.ndarray:
    """Root of the mean of the ratios that have the same label."""
    _, which = np.unique(list(labels), return_inverse=True)
    mean = np.bincount(which, np.concatenate(ratios)) / np.bincount(which)
    return np.asarray(np.sqrt(mean)[which])


def _least(half: Target) -> np.ndarray:
    """Smallest factor of each statistic."""
    return np.where(np.isin(half.families, SKEWED), 1.0, LOWEST)


def expressed(state: State, there: Bench, here: Bench) -> State:
    """A state of one yardstick in another of the same statistics."""
    return replace(
        state,
        train=there.train.expressed(state.train, here.train),
        unseen=cache(lambda: there.test.expressed(state.test, here.test)),
        jacobian=state.jacobian * (there.train.floor / here.train.floor)[:, None],
        bounds=here.train.bounds,
    )
