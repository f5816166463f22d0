"""Dark frames of a virtual sensor, electron by electron, with whatever is hidden in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from dnanalyze.demo.charge import CHARGE
from dnanalyze.demo.digital import DIGITAL
from dnanalyze.demo.hidden import LEVELS, PLACES, HiddenEffect, Moment, Scene, Step, generator
from dnanalyze.demo.outside import OUTSIDE_EFFECTS
from dnanalyze.demo.readout import READOUT
from dnanalyze.demo.sensor import WHITE_DN, VirtualSensor, arrhenius
from dnanalyze.errors import InputError
from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window

CATALOGUED = tuple(e.name for e in (*CHARGE, *READOUT, *DIGITAL))
OUTSIDE = tuple(e.name for e in OUTSIDE_EFFECTS)
EFFECTS: dict[str, HiddenEffect] = {
    e.name: e for e in (*CHARGE, *READOUT, *DIGITAL, *OUTSIDE_EFFECTS)
}

Hidden = Mapping[str, str | Mapping[str, Any]]


def generate(
    sensor: VirtualSensor,
    effects: Hidden | None = None,
    shape: tuple[int, int] = (384, 384),
    temperatures: Sequence[float] | None = None,
    frames: int = 6,
    seed: int = 0,
    first: int = 0,
) -> CaptureSet:
    """Dark frames of a sensor, 12-bit codes in uint16, held in memory.

    The charge of a pixel is Poisson about its log-normal, Arrhenius dark current times the
    exposure; Gaussian read noise and a fixed offset follow, the gain, the pedestal, rounding.
    Every part has random numbers of its own, so a hidden effect leaves those of the rest alone
    (the shot noise of charge that it changes apart).

    Parameters
    ----------
    sensor : VirtualSensor
    effects : dict, optional
        What to hide: a name in `EFFECTS` to a level ("weak", "middling", "strong") or to
        parameters; those not given are as at the "level" among them, or at "middling".
    shape : tuple of int
        (rows, columns).
    temperatures : sequence of float, optional
        C; the sensor's own by default.
    frames : int
        Frames at each temperature.
    seed : int
        Names the silicon and the moments.
    first : int
        Number of the first setting: settings of other numbers are other moments.

    Raises
    ------
    InputError
        Unknown effect, level or parameter.
    """
    scene = Scene(sensor, shape)
    steps = _build(scene, resolve(sensor, effects, seed), seed)
    log_rate = generator(seed, "silicon", "dark current").standard_normal(shape)
    rate = sensor.dark_e_s * np.exp(sensor.dark_spread * log_rate)
    offset = sensor.pixel_offset_e * generator(seed, "silicon", "offset").standard_normal(shape)
    hottest = _rate_map(rate, steps, sensor, sensor.hottest_c)
    chosen = sensor.temperatures_c if temperatures is None else temperatures
    settings = []
    for number, celsius in enumerate(chosen, first):
        point = OperatingPoint(float(celsius), sensor.exposure_s, 1.0)
        charge = _rate_map(rate, steps, sensor, celsius) * sensor.exposure_s
        codes = _expose(sensor, charge, offset, hottest, steps, celsius, frames, (seed, number))
        name = f"T{celsius:+04.0f}C" if float(celsius).is_integer() else f"T{celsius:+06.1f}C"
        made = (_frame(f"{name}/dark_{n:03d}.tif", point, y) for n, y in enumerate(codes))
        settings.append(Setting(point, tuple(made)))
    settings.sort(key=lambda s: s.point.sort_key())
    return CaptureSet("virtual sensor", Sensor(shape), tuple(settings))


def resolve(
    sensor: VirtualSensor, effects: Hidden | None, seed: int = 0
) -> dict[str, dict[str, Any]]:
    """The parameters that `generate` will use, in plain numbers."""
    resolved = {}
    for name, wanted in (effects or {}).items():
        if name not in EFFECTS:
            raise InputError(f"unknown effect {name!r}; valid names: {', '.join(sorted(EFFECTS))}")
        given = {"level": wanted} if isinstance(wanted, str) else dict(wanted)
        level = given.pop("level", "middling")
        if level not in LEVELS:
            raise InputError(f"{name}: unknown level {level!r}; valid: {', '.join(LEVELS)}")
        effect = EFFECTS[name]
        amount = effect.amounts[LEVELS.index(level)]
        parameters = effect.parameters(sensor, amount, generator(seed, "draw", name))
        for key in given:
            if key not in parameters:
                valid = ", ".join(parameters)
                raise InputError(f"{name}: unknown parameter {key!r}; valid: {valid}")
        resolved[name] = parameters | given
    return resolved


def truth(sensor: VirtualSensor, effects: Hidden | None, seed: int = 0) -> dict[str, Any]:
    """What was hidden, and in which sensor, ready for JSON."""
    return {
        "added_to_an_ordinary_sensor": resolve(sensor, effects, seed),
        "sensor": asdict(sensor),
        "seed": seed,
    }


Placed = dict[str, list[tuple[str, Step]]]


def _build(scene: Scene, wanted: dict[str, dict[str, Any]], seed: int) -> Placed:
    """Steps by place; within a place in the order of `EFFECTS`, whatever the order given."""
    placed: Placed = {place: [] for place in PLACES}
    for name in EFFECTS:
        if name in wanted:
            step = EFFECTS[name].build(scene, generator(seed, "silicon", name), **wanted[name])
            placed[step.place].append((name, step))
    return placed


def _rate_map(rate: np.ndarray, steps: Placed, sensor: VirtualSensor, celsius: float) -> np.ndarray:
    """Dark current at a temperature, e-/s."""
    warm = rate * arrhenius(celsius, sensor.activation_ev)
    for _, step in steps["rate"]:
        warm = step.apply(warm, Moment(celsius, 0, generator(0)))
    return warm


def _expose(
    sensor: VirtualSensor,
    charge: np.ndarray,
    offset: np.ndarray,
    hottest: np.ndarray,
    steps: Placed,
    celsius: float,
    frames: int,
    key: tuple[int, int],
) -> list[np.ndarray]:
    """The frames of a setting, in order."""
    seed, setting = key
    memories: dict[str, dict[str, Any]] = {name: {} for s in steps.values() for name, _ in s}
    warm_up = max((step.warm_up for s in steps.values() for _, step in s), default=0)
    made = []
    for frame in range(-warm_up, frames):
        draw = _drawer(seed, setting, frame)

        def run(
            place: str,
            array: np.ndarray,
            frame: int = frame,
            draw: Callable[[str], np.random.Generator] = draw,
        ) -> np.ndarray:
            for name, step in steps[place]:
                now = Moment(celsius, frame, draw(name), memories[name], hottest)
                array = step.apply(array, now)
            return array

        electrons = run("arrived", draw("shot").poisson(run("charge", charge)))
        noise = sensor.read_noise_e * draw("read").standard_normal(charge.shape)
        signal = run("line", electrons + offset + run("noise", noise))
        dn = run("converter", sensor.gain_dn_e * signal + sensor.pedestal_dn)
        codes = run("codes", np.clip(np.rint(dn), 0, WHITE_DN))
        if frame >= 0:
            made.append(np.clip(np.rint(codes), 0, WHITE_DN).astype(np.uint16))
    return made


def _drawer(seed: int, setting: int, frame: int) -> Callable[[str], np.random.Generator]:
    """Generators of a frame by name; frames that only warm up are numbered from a million."""
    number = frame if frame >= 0 else 1_000_000 - frame
    return lambda name: generator(seed, "moment", name, setting, number)


def _frame(name: str, point: OperatingPoint, codes: np.ndarray) -> Frame:
    def load(window: Window | None) -> np.ndarray:
        return codes.copy() if window is None else np.ascontiguousarray(codes[window.slices])

    return Frame(name, point, load)
