"""Measured patches, simulated patches and control patches of each operating point and view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from statistics import fmean

import numpy as np

from dnanalyze.classifier.curve import Area, mean_area
from dnanalyze.classifier.descriptors import random_filters
from dnanalyze.classifier.pictures import around_zero, code_step, compact_frames
from dnanalyze.classifier.places import Places
from dnanalyze.classifier.training import Halves, Learner, Tested, cross_fit, one_thread
from dnanalyze.classifier.views import VIEWS, Cuts, Pictures, View, cut, cuts, pictures_of
from dnanalyze.loaders.captures import CaptureSet, OperatingPoint, Sensor
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

# Between the seeds of simulated sensors: replicates of a fit are numbered from 1 on
SEED_STEP = 7919


@dataclass(frozen=True, eq=False)
class Judged:
    """One operating point and view, with a simulated sensor and a second one as the control.

    Parameters
    ----------
    setting : int
        Number of the operating point.
    point : OperatingPoint
    view : View
    cuts : Cuts
    step : float
        By which values are dithered, DN.
    measured, simulated : mapping
        Samples by fold.
    tested : Tested
        Measured against simulated.
    controls : tuple of float
        Areas of further simulated sensors against the simulated one.
    """

    setting: int
    point: OperatingPoint
    view: View
    cuts: Cuts
    step: float
    measured: Halves
    simulated: Halves
    tested: Tested
    controls: tuple[float, ...]


@dataclass(frozen=True)
class Pool:
    """One view at one operating point, or at all of them together.

    Together they show what no operating point shows by itself, such as a few defects.

    Parameters
    ----------
    parts : tuple of Judged
        One for each operating point.
    """

    parts: tuple[Judged, ...]

    @property
    def area(self) -> Area:
        """Mean over the operating points; what a place has at all of them, it moves once."""
        return mean_area([p.tested.area for p in self.parts])

    @property
    def controls(self) -> tuple[float, ...]:
        """Areas of the controls that all operating points have."""
        return tuple(map(fmean, zip(*(p.controls for p in self.parts), strict=False)))

    @property
    def se(self) -> float:
        """Standard error: from the places, or from the controls where these scatter more.

        A pattern that one sensor or one frame has once all over the field (a phase, a cloud) makes
        two sensors of one design differ at every place alike, which no place can tell.
        """
        own, controls = self.area.se, self.controls
        if len(controls) < 2:
            return own
        scatter = np.var(controls, ddof=1) * (1.0 + 1.0 / len(controls))
        return max(own, float(np.sqrt(scatter)))


def pools(judged: Sequence[Judged]) -> list[Pool]:
    """Every operating point and view, then every view at all operating points together."""
    by_view: dict[str, list[Judged]] = {}
    for one in judged:
        by_view.setdefault(one.view.key, []).append(one)
    together = [Pool(tuple(parts)) for parts in by_view.values() if len(parts) > 1]
    return [*(Pool((one,)) for one in judged), *together]


@dataclass(frozen=True)
class Judge:
    """What trains and tests; the same for every cell.

    Parameters
    ----------
    sensor : Sensor
    settings : sequence of (OperatingPoint, int)
        Operating points that are judged, with their number of frames.
    model : NoiseModel
    places : Places
    learn : callable
    seed : int
    """

    sensor: Sensor
    settings: Sequence[tuple[OperatingPoint, int]]
    model: NoiseModel
    places: Places
    learn: Learner
    seed: int
    filters: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "filters", random_filters(np.random.default_rng(self.seed)))

    def simulated(self, number: int) -> CaptureSet:
        """A simulated sensor by its number; 0 is held against the measured one."""
        model = replace(self.model, seed=self.model.seed + SEED_STEP * (self.seed + number + 1))
        return simulate(model.in_codes, self.sensor.shape, self.settings, sensor=self.sensor)

    def cells(
        self, setting: int, measured: np.ndarray, views: Sequence[View] = VIEWS
    ) -> list[Judged]:
        """Views of one operating point.

        ``measured``: values of the places, (planes, frames, rows, columns), DN.
        """
        values = [measured, *(self._values(setting, number) for number in (0, 1))]
        step = max(map(code_step, values))
        sensors = [
            pictures_of(self._around_zero(v, step, setting, n)) for n, v in enumerate(values)
        ]
        frames = self.settings[setting][1]
        with one_thread():
            return [self._judged(setting, v, step, sensors) for v in views if frames >= v.frames]

    def control(self, judged: Judged, number: int) -> float:
        """Area of one more simulated sensor against the simulated one."""
        values = self._values(judged.setting, number)
        stack = self._around_zero(values, judged.step, judged.setting, number + 1)
        pictures = pictures_of(stack)
        control = cut(judged.view, pictures, self.places, judged.cuts, self.filters)
        with one_thread():
            return self._test(control, judged).area.value

    def _values(self, setting: int, number: int) -> np.ndarray:
        made = self.simulated(number)
        return compact_frames(made, made.settings[setting], self.places)

    def _around_zero(
        self, values: np.ndarray, step: float, setting: int, sensor: int
    ) -> np.ndarray:
        rng = np.random.default_rng((self.seed, setting, sensor))
        return around_zero(values, self.places, step, rng)

    def _judged(self, setting: int, view: View, step: float, sensors: Sequence[Pictures]) -> Judged:
        count = max(map(len, view.shown(sensors[0]).values()))
        where = cuts(view, self.places, count, np.random.default_rng((self.seed, setting)))
        measured, simulated, control = (
            cut(view, pictures, self.places, where, self.filters) for pictures in sensors
        )
        tested = cross_fit(measured, simulated, where.grid, self.learn, self.seed)
        other = cross_fit(control, simulated, where.grid, self.learn, self.seed)
        return Judged(
            setting, self.settings[setting][0], view, where, step, measured, simulated,
            tested, (other.area.value,),
        )  # fmt: skip

    def _test(self, control: Halves, judged: Judged) -> Tested:
        return cross_fit(control, judged.simulated, judged.cuts.grid, self.learn, self.seed)
