"""What a check holds: the simulation on one side, the measurement on the other."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from dnanalyze.analyzers.analyze import analyze_windows
from dnanalyze.analyzers.statistics import SettingStatistics, Statistics, Value
from dnanalyze.checking.targets import POOLED
from dnanalyze.comparator.error import family_errors, pooled
from dnanalyze.errors import InputError
from dnanalyze.fitting.design import Design, design
from dnanalyze.fitting.vectors import prediction, target
from dnanalyze.loaders.captures import CaptureSet, Window
from dnanalyze.model.memo import Memo
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulated_by
from dnanalyze.model.simulator import Simulator
from dnanalyze.progress import Progress

BUDGET_PIXELS = 24_000_000


@dataclass(frozen=True)
class CheckData:
    """The simulation on one side, the measurement (where there is one) on the other.

    Parameters
    ----------
    captures : CaptureSet
        The measurement with a model, else the simulated frames.
    measurement : CaptureSet, optional
    model : NoiseModel, optional
    progress : callable, optional
    """

    captures: CaptureSet
    measurement: CaptureSet | None
    model: NoiseModel | None
    progress: Progress | None = None

    @property
    def name(self) -> str:
        """What is held."""
        return self.captures.name if self.model is None else f"model of seed {self.model.seed}"

    @cached_property
    def plan(self) -> Design:
        """All settings; frames and area within the budget."""
        return design(self.captures, BUDGET_PIXELS, len(self.captures.settings), pool=False)

    @property
    def windows(self) -> list[Window]:
        """(train, test, both)."""
        train, test = self.plan.windows
        return [train, test, Window(train.top, test.bottom, train.left, train.right)]

    def drawn(self, model: NoiseModel) -> list[Statistics]:
        """Statistics of a model's frames in the three windows."""
        simulator = Simulator(model.in_codes, self.plan.shape, Memo(0))
        made = simulated_by(simulator, self.plan.settings, sensor=self.captures.sensor)
        return analyze_windows(made, self.windows, progress=self.progress)

    @cached_property
    def simulated(self) -> list[Statistics]:
        """Of the simulation, in the three windows."""
        if self.model is not None:
            return self.drawn(self.model)
        return analyze_windows(self.plan.captures, self.windows, progress=self.progress)

    @cached_property
    def measured(self) -> list[Statistics] | None:
        """Of the measurement, in the three windows, at the settings of the simulation."""
        if self.measurement is None:
            return None
        if self.measurement is self.captures:
            held = self.plan.captures
        else:
            held = _aligned(self.measurement, self.plan.captures)
        return analyze_windows(held, self.windows, progress=self.progress)

    def errors(self, simulated: list[Statistics]) -> dict[str, float]:
        """Pooled error and that of each family, as of `compare`, over all operating points."""
        assert self.measured is not None
        held = target(self.measured[:2], 1)
        z = held.z(prediction(simulated[:2], 1, held))
        return {POOLED: pooled(z, held.families), **family_errors(z, held.families)}

    @cached_property
    def own_errors(self) -> dict[str, float]:
        """Errors of the simulation."""
        return self.errors(self.simulated)

    def value(
        self, statistics: list[Statistics] | None, at: SettingStatistics, name: str
    ) -> Value | None:
        """A statistic over the field at the same operating point and plane."""
        for setting in statistics[2].settings if statistics else ():
            if setting.point == at.point and setting.plane == at.plane:
                return setting.values.get(name)
        return None


def _aligned(captures: CaptureSet, like: CaptureSet) -> CaptureSet:
    if captures.sensor.shape != like.sensor.shape:
        raise InputError(
            f"{captures.name}: frames of {captures.sensor.shape}, "
            f"those of {like.name} are {like.sensor.shape}"
        )
    by_point = {s.point: s for s in captures.settings}
    missing = [s.point.label(6) for s in like.settings if s.point not in by_point]
    if missing:
        raise InputError(
            f"{captures.name}: nothing measured at {missing[0]}; it has "
            + "; ".join(p.label(6) for p in by_point)
        )
    return replace(captures, settings=tuple(by_point[s.point] for s in like.settings))
