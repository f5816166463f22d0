"""Corrections and denoisers as a camera's processor would run them, frame by frame, on codes.

Arrays are 2-D, DN; edges see the nearest pixel. scipy is imported when used.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

_ROOT3 = np.sqrt(3.0)
# Low-pass of the orthogonal wavelet with two vanishing moments (Daubechies 1988)
DAUBECHIES_2 = np.array([1 - _ROOT3, 3 - _ROOT3, 3 + _ROOT3, 1 + _ROOT3]) / (4.0 * np.sqrt(2.0))


def neighbours(image: np.ndarray) -> np.ndarray:
    """The 8 neighbours of every pixel, shape (8, rows, columns)."""
    rows, columns = image.shape
    padded = np.pad(image, 1, mode="edge")
    shifts = [(r, c) for r in range(3) for c in range(3) if (r, c) != (1, 1)]
    return np.stack([padded[r : r + rows, c : c + columns] for r, c in shifts])


def replace_above_neighbours(image: np.ndarray, threshold: float) -> np.ndarray:
    """The neighbours' median where a pixel is above their maximum by more than ``threshold``."""
    around = neighbours(image)
    return np.where(image > around.max(0) + threshold, np.rint(np.median(around, 0)), image)


def cap_to_neighbours(image: np.ndarray, threshold: float) -> np.ndarray:
    """The neighbours' maximum where a pixel is above it by more than ``threshold`` (star eater)."""
    most = neighbours(image).max(0)
    return np.where(image > most + threshold, most, image)


def replace_by_ratio(image: np.ndarray, black: float, ratio: float, floor: float) -> np.ndarray:
    """The neighbours' median where a signal above black is more than ``ratio`` times it.

    ``floor`` (DN) is the least median that counts, or noise around black would always be corrected.
    """
    median = np.median(neighbours(image), 0)
    defective = image - black > ratio * np.maximum(median - black, floor)
    return np.where(defective, np.rint(median), image)


def replace_listed(image: np.ndarray, sites: np.ndarray) -> np.ndarray:
    """The mean of the 4 next neighbours at the listed sites (a mask)."""
    up, left, right, down = neighbours(image)[[1, 3, 4, 6]]
    return np.where(sites, np.rint((up + left + right + down) / 4.0), image)


def gaussian(image: np.ndarray, sigma_px: float) -> np.ndarray:
    """Gaussian blur."""
    from scipy.ndimage import gaussian_filter

    return gaussian_filter(image.astype(float), sigma_px, mode="nearest")


def median(image: np.ndarray, mix: float) -> np.ndarray:
    """3x3 median, mixed in with the share ``mix``."""
    from scipy.ndimage import median_filter

    return (1.0 - mix) * image + mix * median_filter(image, size=3, mode="nearest")


def bilateral(image: np.ndarray, range_dn: float) -> np.ndarray:
    """Bilateral filter over 5x5 pixels (Tomasi and Manduchi), spatial sigma 1.5 pixels."""
    rows, columns = image.shape
    padded = np.pad(image.astype(float), 2, mode="edge")
    total, weights = np.zeros(image.shape), np.zeros(image.shape)
    for r in range(5):
        for c in range(5):
            near = padded[r : r + rows, c : c + columns]
            space = ((r - 2) ** 2 + (c - 2) ** 2) / 1.5**2
            weight = np.exp(-0.5 * (space + ((near - image) / range_dn) ** 2))
            total += weight * near
            weights += weight
    return total / weights


def nlm(image: np.ndarray, range_dn: float) -> np.ndarray:
    """Non-local means (Buades) within 3 pixels.

    A pixel at which the squared differences of the 2x2 patches add up to s weighs
    exp(-s / (3 range_dn)^2), and nothing below exp(-5).
    """
    reach = 3
    rows, columns = image.shape
    padded = np.pad(image.astype(float), ((reach, reach + 1), (reach, reach + 1)), mode="reflect")
    own = padded[reach : reach + rows + 1, reach : reach + columns + 1]
    total, weights = np.zeros(image.shape), np.zeros(image.shape)
    for r in range(2 * reach + 1):
        for c in range(2 * reach + 1):
            near = padded[r : r + rows + 1, c : c + columns + 1]
            square = (near - own) ** 2
            patch = square[:-1, :-1] + square[1:, :-1] + square[:-1, 1:] + square[1:, 1:]
            apart = patch / (3.0 * range_dn) ** 2
            weight = np.where(apart <= 5.0, np.exp(-apart), 0.0)
            total += weight * near[:-1, :-1]
            weights += weight
    return total / weights


def wavelet(image: np.ndarray, range_dn: float) -> np.ndarray:
    """Soft threshold on three levels of an orthogonal wavelet (Daubechies 2), decimated."""
    rows, columns = image.shape
    padded = np.pad(image.astype(float), ((0, -rows % 8), (0, -columns % 8)), mode="edge")
    return _shrunk(padded, range_dn, 3)[:rows, :columns]


def _shrunk(image: np.ndarray, threshold: float, levels: int) -> np.ndarray:
    """The image with the details of this level, and of those below, shrunk towards 0."""
    if levels == 0:
        return image
    bands = [part for half in _split(image, 0) for part in _split(half, 1)]
    low, details = bands[0], bands[1:]
    kept = [np.sign(d) * np.maximum(np.abs(d) - threshold, 0.0) for d in details]
    low = _shrunk(low, threshold, levels - 1)
    return _joined(_joined(low, kept[0], 1), _joined(kept[1], kept[2], 1), 0)


def _split(image: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """Low and high half-band along an axis, every second sample, the axis taken as periodic."""
    taps = [_every_second(np.roll(image, j - 2, axis), axis) for j in range(4)]
    return np.tensordot(DAUBECHIES_2, taps, 1), np.tensordot(_high_pass(), taps, 1)


def _joined(low: np.ndarray, high: np.ndarray, axis: int) -> np.ndarray:
    """What `_split` took apart: its transpose, since the wavelet is orthogonal."""
    shape = list(low.shape)
    shape[axis] *= 2
    whole = np.zeros(shape)
    for j, (h, g) in enumerate(zip(DAUBECHIES_2, _high_pass(), strict=True)):
        spread = np.zeros(shape)
        _every_second(spread, axis)[...] = h * low + g * high
        whole += np.roll(spread, 2 - j, axis)
    return whole


def _high_pass() -> np.ndarray:
    return DAUBECHIES_2[::-1] * np.array([-1.0, 1.0, -1.0, 1.0])


def _every_second(image: np.ndarray, axis: int) -> np.ndarray:
    return image[::2] if axis == 0 else image[:, ::2]


DENOISERS: dict[str, Callable[[np.ndarray, float], np.ndarray]] = {
    f.__name__: f for f in (gaussian, median, bilateral, nlm, wavelet)
}
