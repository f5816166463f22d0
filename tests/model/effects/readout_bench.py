"""What tests of single effects share: frames of a small model, and clues with chosen values."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint, Window
from dnanalyze.model.effect import Effect, Stage, parameter
from dnanalyze.model.effects.read_noise import ReadNoise
from dnanalyze.model.noise_model import NoiseModel
from dnanalyze.model.simulate import simulate

POINT = OperatingPoint(25.0, 1.0, 1.0)


@dataclass(frozen=True)
class Flat(Effect):
    """An even signal over all pixels."""

    name: ClassVar[str] = "test_flat"
    stage: ClassVar[Stage] = Stage.CHARGE
    level: float = parameter(100.0, "DN", -1e6, 1e6, "level", "linear")

    def apply(self, signal, site):
        return signal + np.float32(self.level)


@dataclass(frozen=True)
class Ramp(Effect):
    """Signal spread evenly and at random from 0 to ``top``."""

    name: ClassVar[str] = "test_ramp"
    stage: ClassVar[Stage] = Stage.CHARGE
    top: float = parameter(256.0, "DN", 0, 1e6, "end", "linear")

    def apply(self, signal, site):
        return signal + np.float32(self.top) * site.uniform()


def frames(*effects, count=2, shape=(128, 128), point=POINT, pedestal=64.0, seed=5, window=None):
    """Frames of a model, float64, shape (count, rows, columns)."""
    model = NoiseModel(effects, pedestal, POINT, seed)
    (setting,) = simulate(model, shape, [(point, count)]).settings
    return np.stack([f.read(window) for f in setting.frames]).astype(float)


def added(effect, count=2, shape=(128, 128), point=POINT, seed=5, noise=1.0):
    """What an effect adds to frames of white noise, shape (count, rows, columns)."""
    base = ReadNoise(noise)
    with_it = frames(base, effect, count=count, shape=shape, point=point, seed=seed)
    return with_it - frames(base, count=count, shape=shape, point=point, seed=seed)


@dataclass
class Given:
    """Clues with given values; what is not given is absent."""

    shape: tuple[int, int] = (256, 256)
    points: tuple[OperatingPoint, ...] = (POINT,)
    seen: dict = field(default_factory=dict)
    model: dict = field(default_factory=dict)
    off: dict = field(default_factory=dict)
    curves: dict = field(default_factory=dict)
    reference: OperatingPoint = POINT
    profiles: dict = field(default_factory=dict)
    whole: tuple[int, int] | None = None
    window: Window | None = None
    standing_out: dict = field(default_factory=dict)
    spectral: dict = field(default_factory=dict)

    @property
    def field(self):
        return self.whole or self.shape

    @property
    def area(self):
        return self.window or Window.whole(self.field)

    def lines(self, axis, setting):
        means = self.profiles.get(axis, [np.empty(0)] * len(self.points))[setting]
        places = self.profiles.get("places", {})
        return (places[setting] if len(places) else np.arange(means.size)), means

    def waves(self, part):
        return self.spectral.get(part, [])

    def colours(self, name):
        return np.array(self.seen.get(f"colours {name}", np.empty((0, 4, 2))), float)

    def defects(self, axis):
        return np.array(self.standing_out.get(axis, []), float).reshape(-1, 4)

    def _array(self, values, name):
        return np.broadcast_to(np.asarray(values.get(name, np.nan), float), len(self.points))

    def measured(self, name):
        return self._array(self.seen, name)

    def simulated(self, name):
        return self._array(self.model, name)

    def z(self, name):
        return self._array(self.off, name)

    def curve(self, name, setting):
        return self.curves[name][setting]

    def modelled_curve(self, name, setting):
        return self.curves[f"model {name}"][setting]


def line_clues(prefix, measured, simulated, shape=(256, 256), z=10.0, **more):
    """Clues in which the four bands of a line spectrum have given powers, DN^2."""
    bands = ("0_0.02", "0.02_0.1", "0.1_0.3", "0.3_0.5")
    names = [f"{prefix}_{b}" for b in bands]
    return Given(
        shape,
        seen=dict(zip(names, np.broadcast_to(measured, 4), strict=True)),
        model=dict.fromkeys(names, simulated),
        off=dict.fromkeys(names, z),
        **more,
    )
