"""Is anything left that the model does not explain? Held against simulated sensors of its make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.comparator.error import pooled
from dnanalyze.diagnosis.deviance import TOLERABLE, deviance
from dnanalyze.diagnosis.trial import Trial, witnessed
from dnanalyze.fitting.least_squares import State, given
from dnanalyze.fitting.predictor import Bench

REPLICATES, FEW = 12, 6
SIGMAS = 4.0
MENDED = 0.5  # share of the squares that may stay


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
    trains, tests = _others(bench, state, replicates)
    errors = [pooled(z, bench.test.families) for z in tests]
    error = pooled(state.test, bench.test.families)
    expected, spread = float(np.mean(errors)), float(np.std(errors, ddof=1))
    left = _left(bench, state, trains, tests)
    calm = error < max(TOLERABLE, expected + SIGMAS * spread)
    return Adequacy(calm and not left, error, expected, spread, left)


def sobered(bench: Bench, before: State, found: Trial) -> Trial:
    """A trial with its gains in units of the scatter of sensors of the make of ``before``.

    Clouds, hot pixels and the phases of hum are drawn anew in every sensor, and are the same at
    all settings of one: what an effect puts right of them is luck, however often it is seen.
    """
    trains, tests = _others(bench, before, FEW)
    gains = []
    for names, old, new in (
        (bench.test.names, before.test, found.state.test),
        (bench.train.names, before.train, found.state.train),
    ):
        scale = np.ones(len(names))
        for name in np.unique(names):
            both = [
                drawn[:, half.names == name]
                for half, drawn in ((bench.train, trains), (bench.test, tests))
            ]
            scatter = np.sqrt(np.mean(np.concatenate(both, axis=1) ** 2))
            scale[names == name] = max(1.0, float(scatter))
        gains.append(deviance(old / scale) - deviance(new / scale))
    gain, fitted_gain = witnessed(bench, found.state.model.get(found.effect), *gains)
    return replace(found, gain=gain, fitted_gain=fitted_gain)


def averaged(bench: Bench, state: State, replicates: int = FEW) -> State:
    """The state with what its model's statistics are on average over sensors of its make.

    Where few tracks or defects make most of a statistic, that of one simulated sensor is luck.
    """
    drawn = [bench.replicate(state.model, r) for r in range(replicates)]
    sides = []
    for side, (half, z) in enumerate(((bench.train, state.train), (bench.test, state.test))):
        own = half.coordinates - z * half.floor
        sides.append(half.z(np.nanmean([own, *(d[side] for d in drawn)], axis=0)))
    return replace(state, train=sides[0], unseen=given(sides[1]))


def mends(bench: Bench, left: Sequence[str], before: State, after: State) -> bool:
    """Whether a model puts most of any one of these statistics right, on both halves."""
    return any(
        all(
            np.sum(new[held.names == name] ** 2) < MENDED * np.sum(old[held.names == name] ** 2)
            for held, old, new in (
                (bench.train, before.train, after.train),
                (bench.test, before.test, after.test),
            )
        )
        for name in left
    )


def _others(bench: Bench, state: State, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Sensors of the model's make against its own, in floors, of the fitted and the judged half.

    (count, statistics) each.
    """
    found = []
    for r in range(count):
        drawn = bench.replicate(state.model, r)
        found.append(
            [
                np.nan_to_num((values - (half.coordinates - z * half.floor)) / half.floor)
                for values, half, z in zip(
                    drawn, (bench.train, bench.test), (state.train, state.test), strict=True
                )
            ]
        )
    return np.array([f[0] for f in found]), np.array([f[1] for f in found])


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
