"""Corrections and denoisers as a camera's processor would run them, frame by frame, on codes.

Arrays are 2-D, DN; edges see the nearest pixel. scipy and scikit-image are imported when used.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dnanalyze.errors import InputError


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
    """Non-local means (Buades) of 3x3 patches within 3 pixels."""
    from skimage.restoration import denoise_nl_means

    return denoise_nl_means(
        image.astype(float), patch_size=3, patch_distance=3, h=range_dn, fast_mode=True
    )


def wavelet(image: np.ndarray, range_dn: float) -> np.ndarray:
    """Soft threshold on three levels of an orthogonal wavelet (Daubechies 2)."""
    try:
        import pywt
    except ImportError:
        raise InputError("denoise kind 'wavelet': install the package PyWavelets") from None
    low, *bands = pywt.wavedec2(image.astype(float), "db2", mode="periodization", level=3)
    soft = [tuple(pywt.threshold(b, range_dn, "soft") for b in level) for level in bands]
    smooth = pywt.waverec2([low, *soft], "db2", mode="periodization")
    return smooth[: image.shape[0], : image.shape[1]]


DENOISERS: dict[str, Callable[[np.ndarray, float], np.ndarray]] = {
    f.__name__: f for f in (gaussian, median, bilateral, nlm, wavelet)
}
