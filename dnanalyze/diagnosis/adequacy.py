"""Is anything left that the model does not explain? Held against simulated sensors of its make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dnanalyze.comparator.error import pooled
from dnanalyze.diagnosis.deviance import TOLERABLE, deviance
from dnanalyze.diagnosis.trial import Trial, error_of, witnessed
from dnanalyze.fitting.least_squares import State, given
from dnanalyze.fitting.level import MEAN
from dnanalyze.fitting.predictor import Bench

REPLICATES, FEW = 12, 6
HASTY = 2  # that mostly show whether anything is left, if not what
WORST = 3  # statistics left; an effect that puts one of these right needs less evidence
SIGMAS = 4.0
EXCUSED = 2.0  # error from which no luck of the replicates excuses a misfit
BEYOND = 6.0  # times their scatter that a misfit must exceed the replicates' to be called left
SCATTER = 0.25  # of the replicates' misfits, in floors, at the least
MENDED = 0.5  # share of the squares that may stay


@dataclass(frozen=True)
class Adequacy:
    """Whether the remaining misfit is what a second sensor would show.

    Parameters
    ----------
    adequate : bool
        Nothing is left, and the mean dark level is kept (see `Level`).
    left : list of str
        Statistics that are off on both halves beyond chance, worst first; the mean level first
        where it is not kept.
    """

    adequate: bool
    left: list[str]


def adequacy(bench: Bench, state: State, replicates: int = REPLICATES) -> Adequacy:
    """Hold the misfit against that of replicates of the model itself.

    They are drawn one by one, and only for as long as they may tell something.
    """
    level = bench.level(state.train, state.test)
    if level is not None and not level.kept:
        rest = _adequacy(bench, state, replicates).left
        return Adequacy(False, [MEAN, *(name for name in rest if name != MEAN)])
    return _adequacy(bench, state, replicates)


def _adequacy(bench: Bench, state: State, replicates: int) -> Adequacy:
    """By the misfit alone."""
    error = error_of(bench, state)
    calm = error < TOLERABLE
    own = _misfits(bench, state.train, state.test)
    errors: list[float] = []
    others: list[dict[str, np.ndarray]] = []
    for r in range(replicates):
        if calm and not _left(own, others, replicates):
            return Adequacy(True, [])
        train, test = _other(bench, state, r)
        others.append(_misfits(bench, train, test))
        errors.append(pooled(test, bench.test.families))
    expected, spread = float(np.mean(errors)), float(np.std(errors, ddof=1))
    left = _left(own, others, replicates)
    calm = calm or error < min(expected + SIGMAS * spread, EXCUSED)
    return Adequacy(calm and not left, left)


def unexplained(bench: Bench, state: State, replicates: int = REPLICATES) -> list[str]:
    """Statistics that a model leaves, worst first; none where it is adequate.

    The farthest ones where the error as a whole is beyond chance, and none of them by itself.
    """
    found = adequacy(bench, state, replicates)
    return found.left or ([] if found.adequate else farthest(bench, state))


def leaves(bench: Bench, state: State) -> bool:
    """Whether any single statistic is left, by as few replicates as say so."""
    return any(adequacy(bench, state, count).left for count in (HASTY, FEW))


def farthest(bench: Bench, state: State, count: int = 3) -> list[str]:
    """Statistics that are farthest off on both halves, worst first."""
    own = _misfits(bench, state.train, state.test)
    return sorted(own, key=lambda name: -float(own[name].min()))[:count]


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


def on_average(bench: Bench, state: State, replicates: int = FEW) -> tuple[Bench, State]:
    """A bench where the luck of the state's simulated sensor is the measured one's too; the state.

    What is simulated near the state lies there as far from the measurement as sensors of its make
    do on average: a fit no longer bends around the tracks or defects of one.
    """
    drawn = [bench.replicate(state.model, r) for r in range(replicates)]
    halves, sides = [], []
    for side, (half, z) in enumerate(((bench.train, state.train), (bench.test, state.test))):
        own = half.coordinates - z * half.floor
        mean = np.nanmean([own, *(d[side] for d in drawn)], axis=0)
        luck = np.nan_to_num(own - mean)
        halves.append(replace(half, coordinates=half.coordinates + luck))
        sides.append(half.z(mean))
    fair = replace(bench, train=halves[0], test=halves[1], part=None)
    return fair, replace(state, train=sides[0], unseen=given(sides[1]))


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
    """Several of `_other`, (count, statistics) each."""
    found = [_other(bench, state, r) for r in range(count)]
    return np.array([f[0] for f in found]), np.array([f[1] for f in found])


def _other(bench: Bench, state: State, number: int) -> tuple[np.ndarray, np.ndarray]:
    """A sensor of the model's make against its own, in floors, on the fitted and judged half."""
    drawn = bench.replicate(state.model, number)
    train, test = (
        np.nan_to_num((values - (half.coordinates - z * half.floor)) / half.floor)
        for values, half, z in zip(
            drawn, (bench.train, bench.test), (state.train, state.test), strict=True
        )
    )
    return train, test


def _misfits(bench: Bench, train: np.ndarray, test: np.ndarray) -> dict[str, np.ndarray]:
    """Pooled misfit of every statistic that both halves tell, on either of them."""
    both = np.intersect1d(bench.train.names, bench.test.names)
    sides = (bench.train, train), (bench.test, test)
    return {
        str(name): np.array([np.sqrt(np.mean(z[half.names == name] ** 2)) for half, z in sides])
        for name in both
    }


def _left(
    own: dict[str, np.ndarray], others: Sequence[dict[str, np.ndarray]], replicates: int
) -> list[str]:
    """Statistics whose misfit lies beyond that of the replicates on both halves, worst first.

    Replicates still to be drawn are supposed to lie right, and all of them to scatter little.
    """
    found = []
    for name, size in own.items():
        null = np.array([other[name] for other in others]).reshape(-1, len(size))
        whole = len(null) == replicates
        scatter = np.maximum(null.std(axis=0, ddof=1), SCATTER) if whole else SCATTER
        worst = float(np.min((size - null.sum(axis=0) / replicates) / scatter))
        if worst > BEYOND:
            found.append((worst, name))
    return [name for _, name in sorted(found, reverse=True)]
