"""Take away what belongs to rows, columns and large scales, so that pixels are exchangeable."""

from __future__ import annotations

import numpy as np


def robust_sd(values: np.ndarray) -> float:
    """Standard deviation of the core of a distribution: 1.4826 median |x - median|."""
    return centre_and_sd(values)[1]


def centre_and_sd(values: np.ndarray, sample: int = 32_768) -> tuple[float, float]:
    """Median and robust standard deviation, of about ``sample`` of the values."""
    some = values.reshape(-1)[:: max(1, values.size // sample)]
    middle = np.median(some)
    return float(middle), float(1.4826 * np.median(np.abs(some - middle)))


def clipped(image: np.ndarray, sigmas: float = 3.0) -> np.ndarray:
    """Values beyond ``sigmas`` robust sd pulled in, about the median."""
    middle, sd = centre_and_sd(image, 8192)
    return np.clip(image, np.float32(middle - sigmas * sd), np.float32(middle + sigmas * sd))


def without_lines(image: np.ndarray) -> np.ndarray:
    """Less the mean of each row and each column (means of the clipped image: hot pixels do not
    pull).
    """
    core = clipped(image)
    rows = core.mean(axis=1, keepdims=True)
    core -= rows
    return image - rows - core.mean(axis=0, keepdims=True)


def without_shading(image: np.ndarray, tile: int = 32) -> np.ndarray:
    """Less lines and less a bilinear surface through the medians of tiles, (rows, columns)."""
    from scipy import ndimage

    flat = without_lines(image)
    h, w = flat.shape
    ny, nx = max(1, h // tile), max(1, w // tile)
    trimmed = flat[: h // ny * ny, : w // nx * nx]
    blocks = trimmed.reshape(ny, trimmed.shape[0] // ny, nx, trimmed.shape[1] // nx)
    medians = np.median(blocks[:, ::2, :, ::2], axis=(1, 3))
    y = np.clip((np.arange(h) + 0.5) * ny / h - 0.5, 0, ny - 1)
    x = np.clip((np.arange(w) + 0.5) * nx / w - 0.5, 0, nx - 1)
    along = ndimage.map_coordinates(
        medians, [y[:, None] * np.ones(nx), np.ones((h, 1)) * np.arange(nx)], order=1
    )
    surface = ndimage.map_coordinates(
        along, [np.arange(h)[:, None] * np.ones(w), np.ones((h, 1)) * x], order=1
    )
    return flat - surface.astype(np.float32)


def pair_differences(stack: np.ndarray) -> np.ndarray:
    """Differences of disjoint pairs of frames over sqrt 2, lines removed: (pairs, rows, columns).

    The fixed pattern cancels; what is left of two independent frames has one frame's temporal
    noise.
    """
    pairs = stack.shape[0] // 2
    return (
        np.stack(
            [
                without_lines((stack[2 * n + 1] - stack[2 * n]) * np.float32(np.sqrt(0.5)))
                for n in range(pairs)
            ]
        )
        if pairs
        else np.empty((0, *stack.shape[1:]), np.float32)
    )


def without_tones(image: np.ndarray, strength: float = 30.0) -> np.ndarray:
    """Less the spectral lines (hum): bins ``strength`` times above the median of their octave."""
    from scipy import fft

    h, w = image.shape
    spectrum = fft.rfft2(image)
    power = spectrum.real**2 + spectrum.imag**2
    rho = np.hypot(np.fft.fftfreq(h)[:, None], np.fft.rfftfreq(w)[None])
    octave = np.ceil(np.log2(np.maximum(rho, 1e-9))).astype(int)
    lines = np.zeros(power.shape, bool)
    for o in range(-5, 1):
        here = octave == o
        if here.any():
            lines |= here & (power > strength * np.median(power[here]))
    if not lines.any():
        return image
    spectrum[lines] = 0
    return fft.irfft2(spectrum, s=(h, w)).astype(image.dtype)
