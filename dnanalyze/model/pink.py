"""Noise with a power-law spectrum, on a field and along the raster scan of a frame.

Both are drawn in the frequency domain over the whole frame, so the power law holds to the lowest
frequency that the frame has; a window is cut out of it. The mean over the frame is zero.
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
    weight = _field_power(white.shape, alpha)
    weight /= np.sum(weight * _multiplicity(white.shape)) / white.size
    np.sqrt(weight, out=weight)
    return fft.irfft2(fft.rfft2(white) * weight.astype(np.float32), s=white.shape)


def mean_power(shape: tuple[int, int], alpha: float) -> float:
    """Variance of a field of power rho^-alpha, without its mean, on a frame of this shape."""
    power = _field_power(shape, alpha) * _multiplicity(shape)
    return float(power.sum()) / (shape[0] * shape[1])


def _field_power(shape: tuple[int, int], alpha: float) -> np.ndarray:
    """rho^-alpha of the modes of `scipy.fft.rfft2`, 0 for the mean."""
    u = fft.rfftfreq(shape[1])[None, :]
    v = fft.fftfreq(shape[0])[:, None]
    rho2 = u * u + v * v
    rho2[0, 0] = 1.0
    power = rho2 ** (-alpha / 2.0)
    power[0, 0] = 0.0
    return power


def _multiplicity(shape: tuple[int, int]) -> np.ndarray:
    """How often a mode of `scipy.fft.rfft2` stands in the full transform, a row."""
    times = np.full(shape[1] // 2 + 1, 2.0)
    times[0] = 1.0
    if shape[1] % 2 == 0:
        times[-1] = 1.0
    return times


def raster_weights(count: int, alpha: float, cutoff: float = 0.0) -> np.ndarray:
    """Amplitudes of the modes f = k / count, k = 1 ... count // 2, for `raster`, float32.

    Parameters
    ----------
    count : int
        Pixel periods in a frame.
    alpha : float
        Exponent of the power spectrum.
    cutoff : float
        Frequency below which it is flat, cycles a pixel period.
    """
    number = np.arange(1, count // 2 + 1)
    if cutoff * count > 1.0:
        number = np.maximum(number, cutoff * count)
    weight = number ** (-alpha / 2.0)
    return (weight / (2.0 * np.sqrt(np.sum(weight * weight)))).astype(np.float32)


def raster(white: np.ndarray, weights: np.ndarray, level: float = 0.0) -> np.ndarray:
    """Frame of noise with a power-law spectrum in the order of readout.

    The noise does not stop between frames, so the frame's own level wanders too: it is given the
    power of the lowest frequency that the frame resolves.

    Parameters
    ----------
    white : ndarray, shape (rows, periods), float32
        Standard normal; a row of the frame takes so many pixel periods.
    weights : ndarray
        Of `raster_weights`.
    level : float
        Standard normal deviate of the frame's level.

    Returns
    -------
    ndarray, shape (rows, periods), float32
        Expected variance 1 over the frame.
    """
    modes = np.zeros(white.size // 2 + 1, np.complex64)
    pairs = np.ascontiguousarray(white).reshape(-1)[: 2 * weights.size]
    np.multiply(pairs.view(np.complex64), weights, out=modes[1:])
    modes[0] = np.sqrt(2.0) * weights[0] * level
    return fft.irfft(modes, n=white.size, norm="forward").reshape(white.shape)
