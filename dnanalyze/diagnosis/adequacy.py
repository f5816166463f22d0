"""Is anything left that the model does not explain? Held against simulated sensors of its make."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dnanalyze.comparator.error import pooled
from dnanalyze.fitting.least_squares import State
from dnanalyze.fitting.predictor import Bench

REPLICATES, FEW = 12, 6
SIGMAS = 4.0
SETTLED = 0.5  # share of the squares that may stay
TOLERABLE = 1.3  # an error below this is never called unexplained on its own


@dataclass(frozen=True)
class Adequacy:
    """Whether the remaining misfit is what a second sensor would show.

    Parameters
    ----------
    adequate : bool
    error : float
        On the judged half.
    expected, spread : float
        Mean and standard deviation of the error of simulated sensors of this make.
    left : list of str
        Statistics that are off on both halves beyond chance, worst first.
    """

    adequate: bool
    error: float
    expected: float
    spread: float
    left: list[str]


def adequacy(bench: Bench, state: State, replicates: int = REPLICATES) -> Adequacy:
    """Hold the misfit against that of replicates of the model itself."""
    base_train = bench.train.coordinates - state.train * bench.train.floor
    base_test = bench.test.coordinates - state.test * bench.test.floor
    errors, trains, tests = [], [], []
    for r in range(replicates):
        train, test = bench.replicate(state.model, r)
        trains.append(np.nan_to_num((train - base_train) / bench.train.floor))
        tests.append(np.nan_to_num((test - base_test) / bench.test.floor))
        errors.append(pooled(tests[-1], bench.test.families))
    error = pooled(state.test, bench.test.families)
    expected, spread = float(np.mean(errors)), float(np.std(errors, ddof=1))
    left = _left(bench, state, np.array(trains), np.array(tests))
    calm = error < max(TOLERABLE, expected + SIGMAS * spread)
    return Adequacy(calm and not left, error, expected, spread, left)


def settles(bench: Bench, before: State, after: State) -> bool:
    """Whether a model puts most of that right, on both halves, which is left ``before`` it."""
    left = adequacy(bench, before, FEW).left
    return bool(left) and all(
        np.sum(new[here] ** 2) < SETTLED * np.sum(old[here] ** 2)
        for held, old, new in (
            (bench.train, before.train, after.train),
            (bench.test, before.test, after.test),
        )
        for here in [np.isin(held.names, left)]
    )


def _left(bench: Bench, state: State, trains: np.ndarray, tests: np.ndarray) -> list[str]:
    """Statistics whose pooled misfit lies beyond that of the replicates on both halves."""
    found = []
    for name in np.unique(bench.test.names):
        worst = np.inf
        for held, z, drawn in (
            (bench.train, state.train, trains),
            (bench.test, state.test, tests),
        ):
            here = held.names == name
            if not here.any():
                worst = 0.0
                continue
            size = np.sqrt(np.mean(z[here] ** 2))
            null = np.sqrt(np.mean(drawn[:, here] ** 2, axis=1))
            worst = min(worst, (size - null.mean()) / max(null.std(ddof=1), 0.25))
        if worst > 6.0:
            found.append((worst, str(name)))
    return [name for _, name in sorted(found, reverse=True)]
