"""Noise with a power-law spectrum, on a field and along the raster scan of a frame.

Both are drawn in the frequency domain over the whole frame and cut to the window, so the power law holds
to the lowest frequency that the frame has. The mean over the frame is zero.
"""

from __future__ import annotations

import numpy as np
from scipy import fft


def field(white: np.ndarray, alpha: float) -> np.ndarray:
    """Gaussian field with power proportional to rho^-alpha, rho in cycles/pixel.

    Parameters
    ----------
    white : ndarray, shape (rows, columns)
        Standard normal field.
    alpha : float
        Exponent of the power spectrum.

    Returns
    -------
    ndarray, shape (rows, columns), float32
        Expected variance 1 over the frame.
    """
    rows, columns = white.shape
    u = fft.rfftfreq(columns)[None, :]
    v = fft.fftfreq(rows)[:, None]
    rho2 = u * u + v * v
    rho2[0, 0] = 1.0
    weight = rho2 ** (-alpha / 4.0)
    weight[0, 0] = 0.0
    twice = np.full(u.shape, 2.0)  # every mode but those of u = 0 and 1/2 stands for its mirror too
    twice[0, 0] = 1.0
    if columns % 2 == 0:
        twice[0, -1] = 1.0
    power = np.sum(weight * weight * twice) / (rows * columns)
    weight = (weight / np.sqrt(power)).astype(np.float32)
    return fft.irfft2(fft.rfft2(white) * weight, s=white.shape)


def raster_weights(count: int, alpha: float) -> np.ndarray:
    """Amplitudes of the modes f = k / count, k = 1 ... count // 2, for `raster`, float32.

    Parameters
    ----------
    count : int
        Pixel periods in a frame.
    alpha : float
        Exponent of the power spectrum.
    """
    weight = np.arange(1, count // 2 + 1) ** (-alpha / 2.0)
    return (weight / (2.0 * np.sqrt(np.sum(weight * weight)))).astype(np.float32)


def raster(white: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Frame of noise with a power-law spectrum in the order of readout.

    Parameters
    ----------
    white : ndarray, shape (rows, periods), float32
        Standard normal; a row of the frame takes so many pixel periods.
    weights : ndarray
        Of `raster_weights`.

    Returns
    -------
    ndarray, shape (rows, periods), float32
        Expected variance 1 over the frame.
    """
    modes = np.zeros(white.size // 2 + 1, np.complex64)
    pairs = np.ascontiguousarray(white).reshape(-1)[: 2 * weights.size]
    np.multiply(pairs.view(np.complex64), weights, out=modes[1:])
    return fft.irfft(modes, n=white.size, norm="forward").reshape(white.shape)
