"""From a model to the numbers that it would have been measured at."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from dnanalyze.analyzers import analyze_windows
from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.fitting.design import Design
from dnanalyze.fitting.vectors import Target, prediction, target
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import Memo, simulate

MEMO_BYTES = 1 << 30


@dataclass(frozen=True)
class Bench:
    """Measured captures on one side, simulated ones of the same layout on the other.

    Parameters
    ----------
    plan : Design
        What is looked at.
    measured : list of Statistics
        Of the train and the test half.
    train, test : Target
    """

    plan: Design
    measured: list[Statistics]
    train: Target
    test: Target
    memo: Memo = field(default_factory=lambda: Memo(MEMO_BYTES))

    def statistics(self, model: NoiseModel) -> list[Statistics]:
        """Statistics of both halves of a simulated capture set."""
        captures = simulate(
            model, self.plan.shape, self.plan.settings, "simulation", self.plan.captures.sensor, self.memo
        )
        return analyze_windows(captures, self.plan.windows)

    def coordinates(self, model: NoiseModel) -> tuple[np.ndarray, np.ndarray]:
        """Predicted coordinates of (train, test)."""
        made = self.statistics(model)
        return prediction(made, 0, self.train), prediction(made, 1, self.test)

    def z(self, model: NoiseModel) -> tuple[np.ndarray, np.ndarray]:
        """Differences in floors, of (train, test)."""
        train, test = self.coordinates(model)
        return self.train.z(train), self.test.z(test)

    def replicate(self, model: NoiseModel, number: int) -> tuple[np.ndarray, np.ndarray]:
        """Predicted coordinates of another sensor of the same make."""
        other = replace(model, seed=model.seed + 1 + number)
        # A replicate is drawn once: its fields would only push the useful ones out of the memo.
        bench = replace(self, memo=Memo(0))
        return bench.coordinates(other)


def bench(plan: Design) -> Bench:
    """Read the captures once and take the statistics of both halves."""
    measured = analyze_windows(plan.captures, plan.windows)
    return Bench(plan, measured, target(measured, 0), target(measured, 1))
