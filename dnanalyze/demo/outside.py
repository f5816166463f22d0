"""Hidden effects that no catalogue lists: what a diagnosis must call unexplained.

Each is physics that some sensor might have, yet each breaks a law that the catalogue's effects
share: one frequency, one axis, one moment, a noise that is the same everywhere.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from dnanalyze.demo.hidden import HiddenEffect, Moment, Scene, Step, of_noise
from dnanalyze.demo.sensor import VirtualSensor

Generator = np.random.Generator
Plain = dict[str, Any]


def _rings_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return of_noise(sensor, amount, rng) | {
        "centre": [float(v) for v in rng.uniform(-0.3, 1.3, 2)],
        "period": float(rng.uniform(6.0, 16.0)),
    }


def _concentric_rings(
    scene: Scene, rng: Generator, e: float, centre: list[float], period: float
) -> Step:
    """Fixed rings of the wafer's growth around a far centre: e sqrt2 cos(2 pi r / period)."""
    r = np.hypot(scene.row - centre[0] * scene.shape[0], scene.column - centre[1] * scene.shape[1])
    rings = e * np.sqrt(2.0) * np.cos(2 * np.pi * r / period)
    return Step("line", lambda y, now: y + rings)


def _reset_ramp(scene: Scene, rng: Generator, e: float) -> Step:
    """A checkerboard of incomplete reset whose size grows from the first row to the last."""
    ramp = np.sqrt(3.0) * scene.row / (scene.shape[0] - 1)
    pattern = e * ramp * (-1.0) ** (scene.row + scene.column)
    return Step("line", lambda y, now: y + pattern)


def _blob_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return of_noise(sensor, amount, rng) | {"radius": float(rng.uniform(0.04, 0.12))}


def _moving_blob(scene: Scene, rng: Generator, e: float, radius: float) -> Step:
    """A soft bright spot of height ``e``, elsewhere in each frame; radius in frame widths."""

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        centre = now.rng.uniform((0, 0), scene.shape)
        away2 = (scene.row - centre[0]) ** 2 + (scene.column - centre[1]) ** 2
        return y + e * np.exp(-0.5 * away2 / (radius * scene.shape[1]) ** 2)

    return Step("line", apply)


def _jitter_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {"relative": amount}


def _quadrant_jitter(scene: Scene, rng: Generator, relative: float) -> Step:
    """Four quadrants, each with its own timing, integrate for times that jitter."""
    quadrant = 2 * (2 * scene.row // scene.shape[0]) + 2 * scene.column // scene.shape[1]

    def apply(charge: np.ndarray, now: Moment) -> np.ndarray:
        times = 1.0 + relative * now.rng.standard_normal(4)
        return charge * np.maximum(0.0, times)[quadrant]

    return Step("charge", apply)


def _noise_draw(sensor: VirtualSensor, amount: float, rng: Generator) -> Plain:
    return {"depth": amount, "period": float(rng.uniform(5.0, 40.0))}


def _column_modulated_noise(scene: Scene, rng: Generator, depth: float, period: float) -> Step:
    """The read noise rises and falls along the columns: sigma (1 + depth cos(2 pi x / period))."""
    factor = np.abs(1.0 + depth * np.cos(2 * np.pi * scene.column / period))
    factor = factor / np.sqrt(np.mean(factor**2))
    return Step("noise", lambda noise, now: noise * factor)


def _column_telegraph(scene: Scene, rng: Generator, e: float) -> Step:
    """One column in twenty jumps between two levels in the middle of a frame, at some row."""
    jumpers = np.flatnonzero(rng.random(scene.shape[1]) < 0.05)

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        turn = now.rng.integers(0, scene.shape[0], jumpers.size)
        start = now.rng.choice([-1.0, 1.0], jumpers.size)
        changed = y.astype(float)
        changed[:, jumpers] += e * np.where(scene.row < turn, start, -start)
        return changed

    return Step("line", apply)


def _drifting_shading(scene: Scene, rng: Generator, e: float) -> Step:
    """A smooth saddle, its axes fixed and its sign and size new in each frame."""
    x, y = scene.column / scene.shape[1] - 0.5, scene.row / scene.shape[0] - 0.5
    saddle = x * y
    saddle = e * saddle / saddle.std()
    return Step("line", lambda frame, now: frame + saddle * now.rng.standard_normal())


def _pair_noise(scene: Scene, rng: Generator, e: float) -> Step:
    """Two diagonal pixels share an amplifier and with it a noise of ``e``."""
    rows, columns = scene.shape

    def apply(y: np.ndarray, now: Moment) -> np.ndarray:
        shared = now.rng.standard_normal((rows // 2 + 1, columns // 2 + 1))
        diagonal = (scene.row + scene.column) % 2 == 0
        return y + e * diagonal * shared[scene.row // 2, scene.column // 2]

    return Step("line", apply)


OUTSIDE_EFFECTS = (
    HiddenEffect("concentric_rings", (0.15, 0.4, 1.0), "standard deviation over the noise",
                 _rings_draw, _concentric_rings),
    HiddenEffect("reset_ramp", (0.15, 0.4, 1.0), "rms over the noise", of_noise, _reset_ramp),
    HiddenEffect("moving_blob", (0.3, 1.0, 3.0), "height over the noise", _blob_draw, _moving_blob),
    HiddenEffect("quadrant_jitter", (5e-3, 0.02, 0.06), "of the dark charge, frame by frame",
                 _jitter_draw, _quadrant_jitter),
    HiddenEffect("column_modulated_noise", (0.15, 0.35, 0.7), "depth of the modulation",
                 _noise_draw, _column_modulated_noise),
    HiddenEffect("column_telegraph", (0.3, 1.0, 3.0), "half a jump over the noise",
                 of_noise, _column_telegraph),
    HiddenEffect("drifting_shading", (0.1, 0.3, 0.8), "standard deviation over the noise",
                 of_noise, _drifting_shading),
    HiddenEffect("pair_noise", (0.25, 0.5, 1.0), "standard deviation over the noise",
                 of_noise, _pair_noise),
)  # fmt: skip
