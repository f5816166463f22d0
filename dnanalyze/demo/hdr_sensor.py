"""An HDR virtual sensor: one pixel array read through several channels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from dnanalyze.demo.sensor import VirtualSensor
from dnanalyze.demo.virtual_sensor import Hidden, generate, resolve
from dnanalyze.loaders.captures import CaptureSet, Frame, Setting

SETTINGS = 1000  # more than a channel has


@dataclass(frozen=True)
class Channel:
    """How a channel differs from the sensor that it reads.

    Parameters
    ----------
    gain, read_noise, exposure : float
        Conversion gain, read noise (e-) and exposure over those of the sensor.
    """

    gain: float = 1.0
    read_noise: float = 1.0
    exposure: float = 1.0


def generate_channels(
    sensor: VirtualSensor,
    channels: Mapping[str, Channel],
    hidden: Mapping[str, Hidden] | None = None,
    pixel: Hidden | None = None,
    shape: tuple[int, int] = (384, 384),
    temperatures: Sequence[float] | None = None,
    frames: int = 6,
    seed: int = 0,
) -> CaptureSet:
    """Dark frames of every channel; the dark current of each pixel is one map for all.

    Each channel is an exposure of its own, with shot and read noise of its own.

    Parameters
    ----------
    sensor : VirtualSensor
    channels : mapping
        Name to what sets it apart.
    hidden : mapping, optional
        Channel to the effects of its readout; see `generate`.
    pixel : mapping, optional
        Effects of the dark current, in all channels; amounts are those of the sensor's exposure.
    shape, temperatures, frames, seed
        See `generate`.

    Raises
    ------
    InputError
        Unknown effect, level or parameter.
    """
    charge = resolve(sensor, pixel, seed)
    settings: list[Setting] = []
    for number, (name, channel) in enumerate(channels.items()):
        own = replace(
            sensor,
            gain_dn_e=sensor.gain_dn_e * channel.gain,
            read_noise_e=sensor.read_noise_e * channel.read_noise,
            exposure_s=sensor.exposure_s * channel.exposure,
        )
        there = {effect: _exposed(p, channel.exposure) for effect, p in charge.items()}
        effects = {**there, **((hidden or {}).get(name) or {})}
        made = generate(own, effects, shape, temperatures, frames, seed, number * SETTINGS)
        settings += [_named(setting, name) for setting in made.settings]
    settings.sort(key=lambda s: s.point.sort_key())
    return CaptureSet("virtual HDR sensor", made.sensor, tuple(settings))


def _exposed(parameters: dict[str, Any], ratio: float) -> dict[str, Any]:
    """The charge of a shorter or longer exposure."""
    return {k: v * ratio if k == "e" else v for k, v in parameters.items()}


def _named(setting: Setting, channel: str) -> Setting:
    point = replace(setting.point, channel=channel)
    frames = (Frame(f"{channel}/{f.name}", point, f.load, f.masked) for f in setting.frames)
    return Setting(point, tuple(frames))
