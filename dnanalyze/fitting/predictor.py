"""From a model to the numbers that it would have been measured at."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.analyzers.statistics import Statistics
from dnanalyze.fitting.design import Design
from dnanalyze.fitting.vectors import Target, prediction, target
from dnanalyze.loaders.captures import Setting
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import Memo, simulate

MEMO_BYTES = 1 << 30
THREADS = 2  # settings simulated at a time


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

    def statistics(self, model: NoiseModel, errors: bool = False) -> list[Statistics]:
        """Statistics of both halves of a simulated capture set."""
        sensor = self.plan.captures.sensor
        made = simulate(model, self.plan.shape, self.plan.settings, "simulation", sensor, self.memo)

        def one(setting: Setting) -> list[Statistics]:
            alone = replace(made, settings=(setting,))
            return analyze_windows(alone, self.plan.windows, workers=1, errors=errors)

        with ThreadPoolExecutor(THREADS) as pool:
            parts = list(pool.map(one, made.settings))
        return [
            Statistics(made.name, sensor, tuple(s for p in parts for s in p[half].settings))
            for half in range(len(self.plan.windows))
        ]

    def coordinates(self, model: NoiseModel) -> tuple[np.ndarray, np.ndarray]:
        """Predicted coordinates of (train, test)."""
        made = self.statistics(model)
        return prediction(made, 0, self.train), prediction(made, 1, self.test)

    def z(self, model: NoiseModel) -> tuple[np.ndarray, np.ndarray]:
        """Differences in floors, of (train, test)."""
        train, test = self.coordinates(model)
        return self.train.z(train), self.test.z(test)

    def only(self, settings: list[int]) -> Bench:
        """The same bench with some of its settings."""
        chosen = tuple(self.plan.captures.settings[i] for i in settings)
        plan = replace(self.plan, captures=replace(self.plan.captures, settings=chosen))
        return replace(
            self, plan=plan, train=self.train.only(settings), test=self.test.only(settings)
        )

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
