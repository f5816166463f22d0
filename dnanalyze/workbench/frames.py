"""Images of the sensor for the screen, and the values of one pixel."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numba import njit

from dnanalyze.loaders.captures import CaptureSet, Frame, Sensor, Window
from dnanalyze.report.fields import over_frames

Kind = Literal["frame", "mean", "temporal noise"]
KINDS: tuple[Kind, ...] = ("frame", "mean", "temporal noise")
MOST_FRAMES = 16  # that a mean or a standard deviation is taken over
CONTRAST = 0.1, 99.9  # percentiles within which the displayed range lies
# Robust standard deviations of the displayed range to either side of the median
COLOUR_DEVIATIONS = 4.0
OUTLIER_DEVIATIONS = 5.0  # robust standard deviations from which a pixel is an outlier
SAMPLE = 1 << 16  # pixels that tell a percentile: the 0.1 % one is that of .1 +- .012 %


@dataclass(frozen=True)
class View:
    """Which image of which operating point.

    Parameters
    ----------
    setting : int
        Operating point, by its place in ``CaptureSet.settings``.
    kind : {"frame", "mean", "temporal noise"}
    frame : int
        Number of the frame, for "frame".
    plane : str
        Colour plane ("R", "Gr", "Gb", "B"), or "" for the whole frame.
    """

    setting: int = 0
    kind: Kind = "frame"
    frame: int = 0
    plane: str = ""


def image(
    captures: CaptureSet,
    view: View,
    window: Window | None = None,
    look: Callable[[], None] = lambda: None,
) -> np.ndarray:
    """The image of a view, DN, float32, (rows, columns) of the frame or of the colour plane.

    "mean" is the mean over frames; "temporal noise" their standard deviation (ddof 1), NaN for
    a single frame. Both take ``MOST_FRAMES`` frames at most.

    Parameters
    ----------
    captures : CaptureSet
    view : View
    window : Window, optional
        Of the frame or of the colour plane; all of it by default.
    look : callable
        Called before each frame.
    """
    cfa = captures.sensor.cfa
    site = None if window is None else _on_sensor(window, view.plane, captures.sensor)

    def part(frame: Frame) -> Frame:
        def load(_: Window | None) -> np.ndarray:
            look()
            return frame.read(site)

        return replace(frame, load=load)

    frames = [part(frame) for frame in captures.settings[view.setting].frames]
    if view.kind == "frame":
        found = frames[view.frame % len(frames)].read().astype(np.float32)
    else:
        found = over_frames(frames[:MOST_FRAMES], view.kind == "temporal noise")
    return np.ascontiguousarray(plane_of(found, view.plane, cfa))


def planes(cfa: tuple[tuple[str, ...], ...] | None) -> list[str]:
    """Colour planes that can be shown, "" (the whole frame) first."""
    if cfa is None:
        return [""]
    return ["", *(f"{colour}{row}{column}" for row, column, colour in _sites(cfa))]


def plane_of(pixels: np.ndarray, plane: str, cfa: tuple[tuple[str, ...], ...] | None) -> np.ndarray:
    """One colour plane of a frame, at its own sampling; the frame itself for ""."""
    for row, column, colour in _sites(cfa or ()):
        if plane == f"{colour}{row}{column}":
            assert cfa is not None
            return pixels[row :: len(cfa), column :: len(cfa[0])]
    return pixels


def _on_sensor(window: Window, plane: str, sensor: Sensor) -> Window:
    """The part of the frame that holds a window of a colour plane; itself for ""."""
    if not plane or sensor.cfa is None:
        return window
    down, across = len(sensor.cfa), len(sensor.cfa[0])
    bottom = min(window.bottom * down, sensor.shape[0])
    right = min(window.right * across, sensor.shape[1])
    return Window(window.top * down, bottom, window.left * across, right)


def _sites(cfa: tuple[tuple[str, ...], ...]) -> list[tuple[int, int, str]]:
    return [(r, c, colour) for r, row in enumerate(cfa) for c, colour in enumerate(row)]


def block_means(pixels: np.ndarray, side: int) -> np.ndarray:
    """Mean of each block of ``side`` x ``side`` pixels.

    Those at the lower and the right edge may hold fewer pixels.
    """
    return pixels if side == 1 else _blocks(pixels, side)


@njit(cache=True, nogil=True)
def _blocks(pixels: np.ndarray, side: int) -> np.ndarray:  # pragma: no cover - compiled
    """Mean of each block of side x side pixels."""
    height, width = pixels.shape
    rows, columns = -(-height // side), -(-width // side)
    out = np.empty((rows, columns), pixels.dtype)
    for i in range(rows):
        for j in range(columns):
            bottom, right = min(height, (i + 1) * side), min(width, (j + 1) * side)
            total = 0.0
            for row in range(i * side, bottom):
                for column in range(j * side, right):
                    total += pixels[row, column]
            out[i, j] = total / ((bottom - i * side) * (right - j * side))
    return out


@dataclass(frozen=True)
class Outliers:
    """Pixels far from the median of a window.

    Parameters
    ----------
    rows, columns : ndarray of int
        Of the image, the farthest pixel first.
    values : ndarray
        DN.
    count : int
        Of all of them; the arrays hold the farthest ones.
    """

    rows: np.ndarray
    columns: np.ndarray
    values: np.ndarray
    count: int

    def moved(self, down: int, across: int) -> Outliers:
        """The same at another place of the image."""
        return replace(self, rows=self.rows + down, columns=self.columns + across)


def outliers(pixels: np.ndarray, window: Window, most: int) -> Outliers:
    """Pixels of a window that deviate by more than 5 robust standard deviations."""
    cut = pixels[window.slices]
    middle, noise = _spread(cut)
    far = np.abs(cut - middle)
    rows, columns = np.nonzero(far > OUTLIER_DEVIATIONS * noise)
    order = np.argsort(-far[rows, columns], kind="stable")[:most]
    at = rows[order], columns[order]
    return Outliers(at[0] + window.top, at[1] + window.left, cut[at], len(rows))


def contrast(images: list[np.ndarray]) -> tuple[float, float]:
    """Displayed range of several images together, DN: robust, and never empty.

    The median and 4 robust standard deviations to either side, as far as there are values.
    """
    values = np.concatenate([_sampled(x).ravel() for x in images])
    values = values[np.isfinite(values)]
    if values.size == 0:
        return 0.0, 1.0
    middle, noise = _spread(values)
    low, high = np.percentile(values, CONTRAST)
    low, high = (
        float(x)
        for x in (
            max(low, middle - COLOUR_DEVIATIONS * noise),
            min(high, middle + COLOUR_DEVIATIONS * noise),
        )
    )
    return (low, high) if high > low else (low - 0.5, low + 0.5)


def _spread(pixels: np.ndarray) -> tuple[float, float]:
    """Median and robust standard deviation: half the distance of the 16 and 84 % quantiles."""
    some = _sampled(np.atleast_2d(pixels))
    some = some[np.isfinite(some)]
    if some.size == 0:
        return 0.0, math.inf
    low, middle, high = np.percentile(some, [16.0, 50.0, 84.0])
    noise = float(high - low) / 2.0
    return float(middle), noise or float(some.std()) or math.inf


def _sampled(pixels: np.ndarray) -> np.ndarray:
    """Pixels on a grid, at most ``SAMPLE`` or so."""
    k = max(1, math.ceil((pixels.size / SAMPLE) ** 0.5)) if pixels.ndim == 2 else 1
    return pixels[::k, ::k] if pixels.shape[0] > 1 else pixels[:, :: k * k]


def pixel(captures: CaptureSet, row: int, column: int) -> list[np.ndarray]:
    """Values of one pixel in every frame of each operating point, DN."""
    at = Window(row, row + 1, column, column + 1)
    return [
        np.array([float(frame.read(at)[0, 0]) for frame in setting.frames])
        for setting in captures.settings
    ]
