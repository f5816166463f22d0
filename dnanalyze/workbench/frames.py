"""Images of the sensor for the screen, and the values of one pixel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numba import njit

from dnanalyze.loaders.captures import CaptureSet, Frame, Window
from dnanalyze.robust import robust_deviation

Kind = Literal["frame", "mean", "temporal noise"]
KINDS: tuple[Kind, ...] = ("frame", "mean", "temporal noise")
MOST_FRAMES = 16  # that a mean or a standard deviation is taken over
CONTRAST = 0.5, 99.5  # percentiles of the displayed range
SAMPLE = 1 << 16  # pixels that tell a percentile: the 0.5 % one is that of .5 +- .03 %


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


def image(captures: CaptureSet, view: View) -> np.ndarray:
    """The image of a view, DN, float32, (rows, columns) of the frame or of the colour plane.

    "mean" is the mean over frames; "temporal noise" their standard deviation (ddof 1), NaN for
    a single frame. Both take ``MOST_FRAMES`` frames at most.
    """
    frames = captures.settings[view.setting].frames
    if view.kind == "frame":
        found = frames[view.frame % len(frames)].read().astype(np.float32)
    else:
        found = _moment(frames[:MOST_FRAMES], view.kind == "temporal noise")
    return plane_of(found, view.plane, captures.sensor.cfa)


def _moment(frames: Sequence[Frame], deviation: bool) -> np.ndarray:
    """Mean or standard deviation over frames, by Welford's recurrence: one frame in memory."""
    mean: np.ndarray | None = None
    squares: np.ndarray | None = None
    for number, frame in enumerate(frames, 1):
        x = frame.read().astype(np.float32)
        if mean is None or squares is None:
            mean, squares = x, np.zeros_like(x)
            continue
        step = x - mean
        mean += step / number
        squares += step * (x - mean)
    assert mean is not None
    assert squares is not None
    if not deviation:
        return mean
    if len(frames) < 2:
        return np.full_like(mean, np.nan)
    return np.sqrt(squares / (len(frames) - 1))


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


def _sites(cfa: tuple[tuple[str, ...], ...]) -> list[tuple[int, int, str]]:
    return [(r, c, colour) for r, row in enumerate(cfa) for c, colour in enumerate(row)]


def for_screen(pixels: np.ndarray, window: Window, most: int) -> np.ndarray:
    """A window of an image with at most ``most`` rows and columns.

    Blocks of k x k pixels become one. A block shows its pixel that deviates most from the
    image's median, so that a hot or a cold pixel stays visible, where it deviates by more than
    5 standard deviations; else its mean.
    """
    rows, columns = window.slices
    cut = pixels[rows, columns]
    k = max(1, -(-max(cut.shape) // most))
    if k == 1:
        return cut
    some = _sampled(cut)
    middle = float(np.nanmedian(some)) if np.isfinite(some).any() else 0.0
    finite = some[np.isfinite(some)]
    noise = robust_deviation(finite, middle) if finite.size else 0.0
    return _blocks(cut, k, middle, 5 * noise)


@njit(cache=True, nogil=True)
def _blocks(  # pragma: no cover - compiled
    pixels: np.ndarray, k: int, middle: float, limit: float
) -> np.ndarray:
    """Mean of each block of k x k pixels, or its farthest pixel where beyond the limit."""
    rows, columns = pixels.shape[0] // k, pixels.shape[1] // k
    out = np.empty((rows, columns), pixels.dtype)
    for i in range(rows):
        for j in range(columns):
            total, far, value = 0.0, -1.0, 0.0
            for row in range(i * k, (i + 1) * k):
                for column in range(j * k, (j + 1) * k):
                    x = pixels[row, column]
                    total += x
                    if abs(x - middle) > far:
                        far, value = abs(x - middle), x
            out[i, j] = value if far > limit else total / (k * k)
    return out


def contrast(
    images: list[np.ndarray], low: float = CONTRAST[0], high: float = CONTRAST[1]
) -> tuple[float, float]:
    """Displayed range, DN: percentiles over several images together, never empty."""
    values = np.concatenate([_sampled(x).ravel() for x in images])
    values = values[np.isfinite(values)]
    if values.size == 0:
        return 0.0, 1.0
    ends = np.percentile(values, [low, high])
    if ends[1] <= ends[0]:
        return float(ends[0] - 0.5), float(ends[0] + 0.5)
    return float(ends[0]), float(ends[1])


def _sampled(pixels: np.ndarray) -> np.ndarray:
    """Pixels on a grid, at most ``SAMPLE`` or so."""
    k = max(1, round((pixels.size / SAMPLE) ** 0.5))
    return pixels[::k, ::k]


def pixel(captures: CaptureSet, row: int, column: int) -> list[np.ndarray]:
    """Values of one pixel in every frame of each operating point, DN."""
    at = Window(row, row + 1, column, column + 1)
    return [
        np.array([float(frame.read(at)[0, 0]) for frame in setting.frames])
        for setting in captures.settings
    ]
