"""Captures of known law, made with NumPy alone."""

from __future__ import annotations

import numpy as np

from dnanalyze.loaders.captures import CaptureSet, Frame, OperatingPoint, Sensor, Setting, Window

ROOM = OperatingPoint(25.0, 1.0)


def dark_frames(
    seed: int,
    count: int,
    shape: tuple[int, int] = (96, 128),
    *,
    spread: float = 0.5,
    noise: float = 2.0,
    hot: float = 0.002,
    columns: float = 0.0,
    drift: float = 0.0,
    hum: float = 0.0,
    codes: bool = True,
) -> list[np.ndarray]:
    """Log-normal pattern, hot pixels, Gaussian noise, hum; rounded to codes or not."""
    rng = np.random.default_rng([seed, 17])
    pattern = 100 + 4 * np.exp(spread * rng.normal(size=shape))
    pattern += (rng.random(shape) < hot) * rng.exponential(60.0, shape)
    pattern += columns * rng.normal(size=shape[1])
    row, column = np.indices(shape)
    frames = []
    for _ in range(count):
        y = pattern + noise * rng.normal(size=shape) + drift * rng.normal()
        if hum:  # a wave of this amplitude, its phase new in every frame
            y += hum * np.cos(2 * np.pi * (0.078 * column + 0.1255 * row + rng.random()))
        frames.append(np.rint(y).astype(np.uint16) if codes else y.astype(np.float32))
    return frames


def capture_of(
    frames: list[np.ndarray],
    point: OperatingPoint = ROOM,
    cfa: tuple[tuple[str, ...], ...] | None = None,
) -> CaptureSet:
    """A capture set of one setting that holds these frames."""
    return captures_of([(point, frames)], cfa)


def captures_of(
    settings: list[tuple[OperatingPoint, list[np.ndarray]]],
    cfa: tuple[tuple[str, ...], ...] | None = None,
    black_level: float | None = None,
) -> CaptureSet:
    """A capture set of several settings."""

    def reader(pixels: np.ndarray):
        def load(window: Window | None) -> np.ndarray:
            return pixels if window is None else np.ascontiguousarray(pixels[window.slices])

        return load

    made = tuple(
        Setting(p, tuple(Frame(f"frame {n}", p, reader(f)) for n, f in enumerate(frames)))
        for p, frames in settings
    )
    shape = settings[0][1][0].shape
    return CaptureSet("made", Sensor(shape, cfa=cfa, black_level=black_level), made)
