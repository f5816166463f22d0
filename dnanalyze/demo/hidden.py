"""What a hidden effect is: where it acts, how strong its levels are, and what it does to a frame.

A frame passes the places of `PLACES` in order. An effect's ``build`` draws what belongs to the
silicon once and returns a `Step`; the step is then called with every frame at its place.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from dnanalyze.demo.sensor import VirtualSensor, arrhenius

LEVELS = ("weak", "middling", "strong")
PLACES = (
    "rate",  # map of dark current at a temperature, e-/s; once a setting
    "charge",  # mean charge of a frame, e-
    "arrived",  # charge after the Poisson draw, e-
    "noise",  # the read noise of a frame, e-
    "line",  # signal with read noise and pixel offsets, e-
    "converter",  # DN before rounding
    "codes",  # DN after rounding and clipping
)


@dataclass(frozen=True)
class Scene:
    """The sensor and the (rows, columns) that an effect is built for."""

    sensor: VirtualSensor
    shape: tuple[int, int]

    @property
    def row(self) -> np.ndarray:
        """Row numbers as a column vector."""
        return np.arange(self.shape[0])[:, None]

    @property
    def column(self) -> np.ndarray:
        """Column numbers as a row vector."""
        return np.arange(self.shape[1])[None, :]

    def random_pixels(self, rng: np.random.Generator, fraction: float) -> np.ndarray:
        """Flat indices of pixels that are each chosen with this probability."""
        return np.flatnonzero(rng.random(self.shape[0] * self.shape[1]) < fraction)


@dataclass(frozen=True)
class Moment:
    """When a step acts.

    Parameters
    ----------
    temperature_c : float
    frame : int
        From 0 in each setting; negative while the setting warms up.
    rng : Generator
        Of this effect in this frame.
    memory : dict
        Of this effect in this setting, carried from frame to frame.
    hottest : ndarray
        Map of the dark current at the sensor's highest temperature, e-/s: what a factory
        calibration would see. Empty while the rates are being made.
    """

    temperature_c: float
    frame: int
    rng: np.random.Generator
    memory: dict[str, Any] = field(default_factory=dict)
    hottest: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))

    def thermal(self, ea_ev: float, reference_c: float) -> float:
        """Arrhenius growth from the reference temperature to now."""
        return arrhenius(self.temperature_c, ea_ev, reference_c)


@dataclass(frozen=True)
class Step:
    """An effect made ready: ``apply(array, moment)`` at ``place``.

    ``warm_up`` frames are run and thrown away before each setting, for effects with a past.
    """

    place: str
    apply: Callable[[np.ndarray, Moment], np.ndarray]
    warm_up: int = 0


@dataclass(frozen=True)
class HiddenEffect:
    """An effect of the virtual sensor.

    Parameters
    ----------
    name : str
        As in the catalogue, or a name outside it.
    amounts : tuple of float
        What weak, middling and strong mean.
    unit : str
        Unit of the amounts in words.
    parameters : callable
        ``parameters(sensor, amount, rng)``: plain numbers that ``build`` takes; what the amount
        leaves open (a frequency, a corner) is drawn.
    build : callable
        ``build(scene, rng, **parameters)``: the step.
    """

    name: str
    amounts: tuple[float, float, float]
    unit: str
    parameters: Callable[[VirtualSensor, float, np.random.Generator], dict[str, Any]]
    build: Callable[..., Step]


def generator(seed: int, *keys: int | str) -> np.random.Generator:
    """Generator of a seed and what it is for; unlike keys are independent."""
    words = [zlib.crc32(k.encode()) if isinstance(k, str) else k for k in keys]
    return np.random.default_rng([seed, *words])


def of_noise(sensor: VirtualSensor, amount: float, rng: np.random.Generator) -> dict[str, Any]:
    """The commonest parameters: ``e`` electrons, a multiple of the sensor's temporal noise."""
    return {"e": amount * sensor.noise_e}
