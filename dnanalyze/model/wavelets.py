"""Wavelet shrinkage, over all shifts of the grid and on one.

A frame is mirrored at its edges, without repeating the edge pixel; results are float32.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from dnanalyze.model.filters import Corner, larger, smaller, with_margin

LEVELS = 3
ROOT = 3**0.5
HAAR = (2**-0.5, 2**-0.5)
DB2 = (1 + ROOT) / 32**0.5, (3 + ROOT) / 32**0.5, (3 - ROOT) / 32**0.5, (1 - ROOT) / 32**0.5
BASES = {"haar": HAAR, "db2": DB2}


def over_all_shifts(image: np.ndarray, threshold: float, levels: int = LEVELS) -> np.ndarray:
    """Soft shrinkage of Haar coefficients, averaged over all shifts of the grid.

    The mean over shifts of the orthonormal transform is the undecimated transform
    (Coifman and Donoho, Translation-invariant de-noising, 1995).

    Parameters
    ----------
    image : ndarray, shape (rows, columns), float32
    threshold : float
        DN, on the orthonormal scale, where white noise of s DN has coefficients of s DN.
    levels : int
        Scales, each twice the one before.
    """
    margin = 2**levels - 1
    return _shrink(with_margin(image, margin), threshold, 0, levels)[margin:-margin, margin:-margin]


def _shrink(smooth: np.ndarray, threshold: float, level: int, levels: int) -> np.ndarray:
    if level == levels:
        return smooth
    step = 2**level
    bands = _quads(smooth, step, threshold / 2 ** (level + 1))
    bands[0] = _shrink(bands[0], threshold, level + 1, levels)
    return _mean_of_quads(bands, step)


@njit(cache=True, nogil=True)
def _quads(a: np.ndarray, step: int, limit: float) -> np.ndarray:
    """Mean of every four pixels so far apart, and their differences drawn towards 0 by a limit.

    Around the end. Coefficients shrink by 2 a level against the orthonormal scale.
    """
    rows, columns = a.shape
    bands = np.empty((4, rows, columns), np.float32)
    for r in range(rows):
        here, below = a[r], a[(r + step) % rows]
        for part in range(2):
            first, last = (0, columns - step) if part == 0 else (columns - step, columns)
            far = step - part * columns
            for c in range(first, last):
                upper, lower = here[c] + here[c + far], below[c] + below[c + far]
                left, right = here[c] - here[c + far], below[c] - below[c + far]
                bands[0, r, c] = np.float32(0.25) * (upper + lower)
                bands[1, r, c] = _drawn(np.float32(0.25) * (left + right), limit)
                bands[2, r, c] = _drawn(np.float32(0.25) * (upper - lower), limit)
                bands[3, r, c] = _drawn(np.float32(0.25) * (left - right), limit)
    return bands


@njit(cache=True, nogil=True, inline="always")
def _drawn(x: float, limit: float) -> float:
    """Drawn towards 0 by a limit, and not beyond it."""
    return x - larger(smaller(x, limit), -limit)


@njit(cache=True, nogil=True)
def _mean_of_quads(bands: np.ndarray, step: int) -> np.ndarray:
    """Every pixel as the mean of what the four quads say that it is a part of."""
    _, rows, columns = bands.shape
    result = np.empty((rows, columns), np.float32)
    for r in range(rows):
        here, above = bands[:, r], bands[:, (r - step) % rows]
        for part in range(2):
            first, last = (step, columns) if part == 0 else (0, step)
            back = part * columns - step
            for c in range(first, last):
                b = c + back
                as_upper = (
                    here[0, c] + here[1, c] + here[2, c] + here[3, c]
                    + here[0, b] - here[1, b] + here[2, b] - here[3, b]
                )  # fmt: skip
                as_lower = (
                    above[0, c] + above[1, c] - above[2, c] - above[3, c]
                    + above[0, b] - above[1, b] - above[2, b] + above[3, b]
                )  # fmt: skip
                result[r, c] = np.float32(0.25) * (as_upper + as_lower)
    return result


def on_grid(
    image: np.ndarray,
    threshold: float,
    basis: tuple[float, ...],
    corner: Corner = (0, 0),
    levels: int = LEVELS,
) -> np.ndarray:
    """Soft shrinkage of the coefficients of an orthonormal wavelet, decimated: on one grid.

    It leaves a lattice of 2, 4 ... 2^levels pixels (Mallat, IEEE PAMI 11, 674, 1989).

    Parameters
    ----------
    image : ndarray, shape (rows, columns), float32
    threshold : float
        DN, on the orthonormal scale, where white noise of s DN has coefficients of s DN.
    basis : tuple of float
        Taps of the low pass: ``HAAR``, ``DB2``.
    corner : (int, int)
        Row and column of the frame at which the image begins; the grid begins with the frame.
    levels : int
        Scales, each twice the one before.
    """
    block = 2**levels
    far = -(-reach(basis, levels) // block) * block
    pads = [
        (far + at % block, far + -(at + n) % block)
        for at, n in zip(corner, image.shape, strict=True)
    ]
    low = np.array(basis, np.float32)
    high = low[::-1] * np.resize(np.array([1, -1], np.float32), low.size)
    kept = _shrink_on_grid(np.pad(image, pads, "reflect"), np.float32(threshold), low, high, levels)
    inside = [slice(a, a + n) for (a, _), n in zip(pads, image.shape, strict=True)]
    return kept[tuple(inside)]


def reach(basis: tuple[float, ...], levels: int = LEVELS) -> int:
    """Pixels around one that the coefficients which it belongs to look at."""
    return (len(basis) - 1) * (2**levels - 1)


def _shrink_on_grid(
    image: np.ndarray, threshold: np.float32, low: np.ndarray, high: np.ndarray, levels: int
) -> np.ndarray:
    if levels == 0:
        return image
    rows = [_coefficients(image, taps, 0) for taps in (low, high)]
    smooth, *details = (_coefficients(part, taps, 1) for part in rows for taps in (low, high))
    smooth = _shrink_on_grid(smooth, threshold, low, high, levels - 1)
    across, down, both = (_soft(d, threshold) for d in details)
    upper = _signal(smooth, across, low, high, 1)
    return _signal(upper, _signal(down, both, low, high, 1), low, high, 0)


def _coefficients(a: np.ndarray, taps: np.ndarray, axis: int) -> np.ndarray:
    """Every second value of the correlation with the taps, around the end."""
    a = np.moveaxis(a, axis, 0)
    longer = np.concatenate([a, a[: len(taps) - 2]])
    coefficients = sum(t * longer[k : k + len(a) : 2] for k, t in enumerate(taps))
    return np.moveaxis(np.asarray(coefficients), 0, axis)


def _signal(
    smooth: np.ndarray, detail: np.ndarray, low: np.ndarray, high: np.ndarray, axis: int
) -> np.ndarray:
    """What has these coefficients: the transpose of `_coefficients` of both, and its inverse."""
    parts = [np.moveaxis(p, axis, 0) for p in (smooth, detail)]
    length, beyond = 2 * len(parts[0]), len(low) - 2
    longer = np.zeros((length + beyond, parts[0].shape[1]), np.float32)
    for part, taps in zip(parts, (low, high), strict=True):
        for k, t in enumerate(taps):
            longer[k : k + length : 2] += t * part
    longer[:beyond] += longer[length:]
    return np.moveaxis(longer[:length], 0, axis)


def _soft(values: np.ndarray, threshold: np.float32) -> np.ndarray:
    """Values drawn towards 0 by the threshold, and not beyond it."""
    return values - np.clip(values, -threshold, threshold)
