"""Shared by the tests of the charge and everyday effects: a flat sensor, frames, made-up clues."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.convolved_lognormal import ConvolvedLognormal
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulator import Simulator
from dnanalyze.thermal import arrhenius

HERE = OperatingPoint(25.0, 1.0, 1.0)
WARM = OperatingPoint(45.0, 1.0, 1.0)
LONG = OperatingPoint(25.0, 3.0, 1.0)
LOUD = OperatingPoint(25.0, 1.0, 2.0)


def flat(level: float) -> ConvolvedLognormal:
    """A dark signal that is the same in all pixels, proportional to exposure."""
    return ConvolvedLognormal(mu=math.log(level), delta=1e-4, phi=0.0, sigma=1e-6)


def frames(
    effects: Effect | tuple[Effect, ...],
    shape: tuple[int, int] = (256, 256),
    count: int = 1,
    point: OperatingPoint = HERE,
    seed: int = 0,
    first: int = 0,
) -> np.ndarray:
    """Frames of a model with these effects, float64, (count, rows, columns)."""
    chain = effects if isinstance(effects, tuple) else (effects,)
    simulator = Simulator(NoiseModel(chain, 0.0, HERE, seed), shape)
    return np.stack([simulator.frame(point, first + n) for n in range(count)]).astype(float)


def same_from_a_window(effects: tuple[Effect, ...], frame: int = 3) -> None:
    """The pixels of windows, at the border too, are those of the whole frame, bit by bit."""
    model = NoiseModel(effects, 5.0, HERE, 7)
    whole = Simulator(model, (70, 90)).frame(WARM, frame)
    for window in (Window(11, 40, 23, 61), Window(0, 9, 80, 90), Window(69, 70, 0, 90)):
        part = Simulator(model, (70, 90)).frame(WARM, frame, window)
        np.testing.assert_array_equal(part, whole[window.slices])


def growth(ea_ev: float) -> float:
    """Arrhenius factor from HERE to WARM."""
    return arrhenius(WARM.temperature_c, HERE.temperature_c, ea_ev)


@dataclass
class MadeUpClues:
    """Statistics as a test states them; what it does not state is absent."""

    points: tuple[OperatingPoint, ...] = (HERE,)
    reference: OperatingPoint = HERE
    shape: tuple[int, int] = (512, 512)
    seen: dict[str, object] = field(default_factory=dict)
    model: dict[str, object] = field(default_factory=dict)
    stands_out: tuple[str, ...] = ()
    curves: dict[str, list[np.ndarray]] = field(default_factory=dict)

    @property
    def field(self) -> tuple[int, int]:
        return self.shape

    @property
    def area(self) -> Window:
        return Window.whole(self.shape)

    def _all(self, values: object) -> np.ndarray:
        return np.broadcast_to(np.asarray(values, float), (len(self.points),)).copy()

    def measured(self, name: str) -> np.ndarray:
        return self._all(self.seen.get(name, np.nan))

    def simulated(self, name: str) -> np.ndarray:
        return self._all(self.model.get(name, np.nan))

    def z(self, name: str) -> np.ndarray:
        return self._all(10.0 if name in self.stands_out else 0.0)

    def colours(self, name: str) -> np.ndarray:
        return self.seen.get(f"colours {name}", np.empty((0, 4, 2)))

    def lines(self, axis: str, setting: int) -> tuple[np.ndarray, np.ndarray]:
        return np.empty(0, int), np.empty(0)

    def defects(self, axis: str) -> np.ndarray:
        return np.empty((0, 4))

    def curve(self, name: str, setting: int) -> np.ndarray:
        return self.curves[name][setting]
