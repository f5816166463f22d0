"""Stacks of virtual frames for the tests of this folder."""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.demo import VirtualSensor, generate

# Finely digitised, so that rounding (1/12 DN^2) hides nothing: 4 DN/e-, noise 8 DN.
CALM = VirtualSensor(
    gain_dn_e=4.0,
    read_noise_e=2.0,
    pixel_offset_e=0.5,
    dark_e_s=20.0,
    dark_spread=0.4,
    activation_ev=0.62,
    pedestal_dn=200.0,
    exposure_s=0.05,
    temperatures_c=(25.0, 40.0, 55.0, 70.0, 85.0),
)
COLD, HOT = 25.0, 85.0


def stack(
    effects: dict[str, Any] | None = None,
    celsius: float = COLD,
    frames: int = 6,
    shape: tuple[int, int] = (192, 256),
    sensor: VirtualSensor = CALM,
    seed: int = 5,
) -> np.ndarray:
    """Frames of one temperature, DN, shape (frames, rows, columns)."""
    made = generate(sensor, effects, shape, (celsius,), frames, seed)
    return np.stack([f.read() for f in made.settings[0].frames]).astype(float)


def added(effects: dict[str, Any], celsius: float = COLD, **more: Any) -> np.ndarray:
    """What an effect adds, e-: all else has the same random numbers, rounding (1/6 DN^2) apart."""
    sensor = more.get("sensor", CALM)
    return (stack(effects, celsius, **more) - stack(None, celsius, **more)) / sensor.gain_dn_e


ROUNDING_E2 = 1.0 / 6.0 / CALM.gain_dn_e**2  # variance of what two roundings leave, e-^2
