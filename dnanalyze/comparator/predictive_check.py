"""Predictive check of the present model by parametric bootstrap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dnanalyze.comparator.error import TOLERABLE, pooled
from dnanalyze.fitting.design import MOST_SETTINGS
from dnanalyze.fitting.least_squares import linear_step
from dnanalyze.fitting.problem import FitProblem
from dnanalyze.fitting.state import State
from dnanalyze.fitting.yardstick import REPLICATES, measured_by
from dnanalyze.significance import CERTAIN

SCATTER = (2.0 * MOST_SETTINGS) ** -0.5  # of a root mean square over all operating points: .25

# Misfits of a model and their standard deviations, on the fitted and on the held-out half.
Halves = tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def error_of(problem: FitProblem, state: State) -> float:
    """Model error on the held-out half, by the yardstick of ``problem``."""
    return pooled(state.test, problem.test.families)


@dataclass(frozen=True)
class FittedModel:
    """The hypothesis that nothing is missing: a fitted model, and replicates of it.

    Parameters
    ----------
    problem : FitProblem
        Statistics of the captures.
    state : State
        The fitted model.
    """

    problem: FitProblem
    state: State

    @classmethod
    def of(cls, problem: FitProblem, state: State) -> FittedModel:
        """The hypothesis by the yardstick of its own replicates."""
        return cls(*measured_by(problem, state))

    @cached_property
    def error(self) -> float:
        """Model error on the held-out half."""
        return error_of(self.problem, self.state)

    @cached_property
    def replicates(self) -> tuple[np.ndarray, np.ndarray]:
        """Sensors of the same design less the model's own, (replicates, statistics) a half.

        In standard deviations of the measurement.
        """
        sides = (self.problem.train, self.state.train), (self.problem.test, self.state.test)
        drawn = [self.problem.replicate(self.state.model, r) for r in range(REPLICATES)]
        train, test = (
            z - np.array([half.z(d[i]) for d in drawn]) for i, (half, z) in enumerate(sides)
        )
        return train, test

    @cached_property
    def sensors(self) -> tuple[np.ndarray, np.ndarray]:
        """Misfits of the model's own sensor and of its replicates, each fitted by a linear step.

        Each simulated sensor is first refitted by one linear step, because the model itself was
        fitted to the captures.
        """
        train, test = (
            own - np.vstack([np.zeros_like(own), drawn])
            for own, drawn in zip((self.state.train, self.state.test), self.replicates, strict=True)
        )
        return linear_step(self.state, self.problem.train, self.problem.test, train, test)

    @cached_property
    def predictive(self) -> Halves:
        """Mean misfit of `sensors`, and standard deviation of another sensor about it, at least 1.

        Of n sensors the one after them differs from their mean by (1 + 1/n) of the variance. At
        every operating point its own, since much of what varies grows with the dark signal.
        """
        variances = (np.var(z, axis=0, ddof=1) * (1.0 + 1.0 / len(z)) for z in self.sensors)
        one, other = (
            np.array([str(k) for k in h.keys]) for h in (self.problem.train, self.problem.test)
        )
        train, test = (z.mean(axis=0) for z in self.sensors)
        sd_train, sd_test = _pooled(one, other, *variances)
        return (train, sd_train), (test, sd_test)

    @cached_property
    def left(self) -> list[str]:
        """Statistics that differ on both halves beyond the replicates, worst first.

        The level is the first where it is not within its limits (see `Level`).
        """
        level = self.problem.level(self.state.train, self.state.test)
        rest = self._beyond()
        if level is None or level.kept:
            return rest
        return [level.statistic, *(name for name in rest if name != level.statistic)]

    @cached_property
    def adequate(self) -> bool:
        """Whether nothing is left, and the error as a whole is one that a replicate shows."""
        if self.left:
            return False
        if self.error < TOLERABLE:
            return True
        families = self.problem.test.families
        return self.error < max(pooled(z, families) for z in self.replicates[1])

    @property
    def unexplained(self) -> list[str]:
        """`left`, or the largest three differences where only the error as a whole is beyond."""
        if self.left or self.adequate:
            return self.left
        own = self._misfits((self.state.train, self.state.test))
        return sorted(own, key=lambda name: -float(own[name].min()))[:3]

    def corrects(self, names: Sequence[str], after: State) -> bool:
        """Whether another model halves the squares of one of these statistics, on both halves."""
        sides = (
            (self.problem.train.names, self.state.train, after.train),
            (self.problem.test.names, self.state.test, after.test),
        )
        return any(
            all(
                2.0 * np.sum(new[of == name] ** 2) < np.sum(old[of == name] ** 2)
                for of, old, new in sides
            )
            for name in names
        )

    def _misfits(self, halves: Sequence[np.ndarray]) -> dict[str, np.ndarray]:
        """Root mean square misfit of each statistic that both halves have, on either of them."""
        names = self.problem.train.names, self.problem.test.names
        return {
            str(name): np.array(
                [
                    np.sqrt(np.mean(z[..., of == name] ** 2, axis=-1))
                    for of, z in zip(names, halves, strict=True)
                ]
            )
            for name in np.intersect1d(*names)
        }

    def _beyond(self) -> list[str]:
        own = self._misfits((self.state.train, self.state.test))
        if all(size.min() <= CERTAIN * SCATTER for size in own.values()):
            return []  # whatever replicates show
        drawn = self._misfits(self.replicates)
        found = []
        for name, size in own.items():
            mean, sd = drawn[name].mean(axis=1), drawn[name].std(axis=1, ddof=1)
            worst = float(np.min((size - mean) / np.maximum(sd, SCATTER)))
            if worst > CERTAIN:
                found.append((worst, name))
        return [name for _, name in sorted(found, reverse=True)]


def _pooled(
    by: np.ndarray, by_test: np.ndarray, train: np.ndarray, test: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Root of the mean of the squares of either half that have the same label, at least 1."""
    _, which = np.unique(np.concatenate([by, by_test]), return_inverse=True)
    mean = np.bincount(which, np.concatenate([train, test])) / np.bincount(which)
    sd = np.sqrt(np.maximum(mean, 1.0))[which]
    return sd[: by.size], sd[by.size :]
