"""Frames of one operating point as pictures around 0, with nothing of their level left."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dnanalyze.analyzers.kernels.sorting import order_statistic
from dnanalyze.classifier.places import FOLDS, Places
from dnanalyze.loaders.captures import CaptureSet, Frame, Setting, Window
from dnanalyze.loaders.mosaic import plane_names

CLIP = 4.0  # robust standard deviations: a normal frame loses 1 of 16,000 pixels
ROUNDS = 3  # of clipping; the third changes a mean by less than its standard error


def compact_frames(captures: CaptureSet, setting: Setting, places: Places) -> np.ndarray:
    """Values of the places in every frame and colour plane.

    Parameters
    ----------
    captures : CaptureSet
        Measured or simulated.
    setting : Setting
        One of its own.
    places : Places
        Of a colour plane.

    Returns
    -------
    ndarray of float32
        (planes, frames, rows, columns), DN.
    """
    cfa = captures.sensor.cfa
    period = (1, 1) if cfa is None else (len(cfa), len(cfa[0]))
    corners = [(0, 0)] if cfa is None else list(plane_names(cfa))
    simulated = captures.source is None and not places.contiguous
    made = [
        _by_windows(frame, places, corners, period)
        if simulated
        else _whole(frame, places, corners, period)
        for frame in setting.frames
    ]
    return np.stack(made, axis=1)


def _whole(
    frame: Frame, places: Places, corners: Sequence[tuple[int, int]], period: tuple[int, int]
) -> np.ndarray:
    """Of a frame that is read in one piece."""
    pixels = frame.read()
    planes = [places.compact(pixels[r :: period[0], c :: period[1]]) for r, c in corners]
    return np.stack(planes).astype(np.float32)


def _by_windows(
    frame: Frame, places: Places, corners: Sequence[tuple[int, int]], period: tuple[int, int]
) -> np.ndarray:
    """Of a simulated frame, whose other pixels need not be drawn."""
    down, right = period
    made = np.empty((len(corners), len(places.rows.starts), places.rows.width, places.shape[1]))
    for number, own in enumerate(places.windows()):
        window = Window(down * own.top, down * own.bottom, right * own.left, right * own.right)
        block = frame.read(window)
        row, column = divmod(number, len(places.columns.starts))
        across = slice(column * places.columns.width, (column + 1) * places.columns.width)
        for plane, (r, c) in enumerate(corners):
            made[plane, row, :, across] = block[r::down, c::right]
    return made.reshape(len(corners), *places.shape).astype(np.float32)


def code_step(values: np.ndarray) -> float:
    """Distance of the codes, DN; 0 where the values are not whole codes."""
    flat = values.ravel()
    whole = np.rint(flat)
    if not np.array_equal(flat, whole):
        return 0.0
    apart = whole.astype(np.int64) - int(whole[0])
    return float(max(1, np.gcd.reduce(apart)))


def around_zero(
    values: np.ndarray, places: Places, step: float, rng: np.random.Generator
) -> np.ndarray:
    """Frames less their clipped means, after dithering by one code.

    The level of a frame counts for nothing, nor does the fraction of a code that its subtraction
    leaves: the uniform noise fills the codes first. Each fold's half of the bands loses a level of
    its own: a common one would make what is high by chance in one half low in the other.

    Parameters
    ----------
    values : ndarray
        (planes, frames, rows, columns), DN.
    places : Places
    step : float
        Distance of the codes, DN; 0 dithers nothing.
    rng : Generator

    Returns
    -------
    ndarray of float32
        (planes, frames, rows, columns), DN.
    """
    made = values.astype(np.float32)
    if step:
        made += np.float32(step) * rng.random(made.shape, dtype=np.float32)
    for fold in FOLDS:
        rows, columns = places.half(fold)
        for frame in made.swapaxes(0, 1):
            index = (slice(None), *np.ix_(rows, columns))
            frame[index] -= np.float32(clipped_mean(frame[index]))
    return made


def clipped_mean(values: np.ndarray) -> float:
    """Mean without what lies more than `CLIP` robust standard deviations off."""
    kept = np.asarray(values, np.float32).ravel()
    for _ in range(ROUNDS):
        low, middle, high = middle_and_sides(kept)
        reach = CLIP * max(high - low, 1e-12) / 2.0
        kept = kept[np.abs(kept - np.float32(middle)) <= reach]
    return float(kept.mean(dtype=np.float64)) if kept.size else middle


def middle_and_sides(values: np.ndarray) -> tuple[float, float, float]:
    """Quantiles of float32 values at -1, 0 and 1 sigma of a normal distribution, DN."""
    last = values.size - 1
    low, middle, high = (order_statistic(values, round(q * last))[0] for q in (0.16, 0.5, 0.84))
    return float(low), float(middle), float(high)
