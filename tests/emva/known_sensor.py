"""Dark frames of known gain, dark current and nonuniformity, made with NumPy alone."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.ndimage import laplace

from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window

BOLTZMANN_EV = 8.617333e-5


def doubling_step(energy_ev: float, low_c: float, high_c: float) -> float:
    """k T^2 ln 2 / Ea at the middle of the inverse temperatures, C."""
    low, high = low_c + 273.15, high_c + 273.15
    middle = 2 / (1 / low + 1 / high)
    return BOLTZMANN_EV * middle**2 * math.log(2) / energy_ev


def sensor_frames(
    seed: int,
    points: Sequence[tuple[float | None, float | None, int]],
    shape: tuple[int, int] = (96, 128),
    *,
    gain: float = 0.8,
    read_e: float = 3.0,
    current_e_s: float = 40.0,
    energy_ev: float = 0.62,
    spread: float = 0.3,
    row_dn: float = 0.0,
    col_dn: float = 0.0,
    pixel_dn: float = 1.0,
    row_noise_dn: float = 0.0,
    black: float = 100.0,
    top: int = 4095,
    hits: float = 0.0,
    jitter: float = 0.0,
    read_spread: float = 0.0,
    coupling: float = 0.0,
    cfa: tuple[tuple[str, ...], ...] | None = None,
    system_gain: float | None = None,
) -> CaptureSet:
    """Codes at points (temperature C, exposure s, frames); 25 C is the reference.

    ``hits`` is the share of pixels that a hit of 400 e- strikes in a second of each frame;
    ``jitter`` the relative standard deviation of the exposure of a frame; ``read_spread`` that of
    the logarithm of the read noise over the pixels. ``coupling`` is the share of a pixel's charge
    in each adjacent one.
    """
    rng = np.random.default_rng([seed, 1288])
    rate = current_e_s * np.exp(spread * rng.normal(size=shape) - spread**2 / 2)
    offset = (
        black
        + row_dn * rng.normal(size=(shape[0], 1))
        + col_dn * rng.normal(size=shape[1])
        + pixel_dn * rng.normal(size=shape)
    )
    read = read_e * np.exp(read_spread * rng.normal(size=shape)) if read_spread else read_e
    settings = []
    for celsius, exposure, frames in points:
        kelvin = 298.15 if celsius is None else celsius + 273.15
        warm = math.exp(energy_ev / BOLTZMANN_EV * (1 / 298.15 - 1 / kelvin))
        t = 1.0 if exposure is None else exposure
        point = OperatingPoint(celsius, exposure)
        made = []
        for _ in range(frames):
            longer = max(1.0 + jitter * rng.normal(), 0.0) if jitter else 1.0
            charge = rng.poisson(rate * warm * t * longer).astype(float)
            if coupling:
                charge += coupling * laplace(charge, mode="reflect")
            charge = charge + read * rng.normal(size=shape)
            charge = charge + 400.0 * (rng.random(shape) < hits * t)
            y = offset + gain * charge + row_noise_dn * rng.normal(size=(shape[0], 1))
            made.append(np.clip(np.rint(y), 0, top).astype(np.uint16))
        named = [Frame(f"{point.label()} {n}", point, _loader(y)) for n, y in enumerate(made)]
        settings.append(Setting(point, tuple(named)))
    sensor = Sensor(shape, cfa=cfa, system_gain_dn_e=system_gain)
    return CaptureSet("known", sensor, tuple(settings))


def _loader(pixels: np.ndarray):
    def load(window: Window | None) -> np.ndarray:
        return pixels if window is None else np.ascontiguousarray(pixels[window.slices])

    return load
