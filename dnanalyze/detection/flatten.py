"""Take away what belongs to rows, columns and large scales, so that pixels are exchangeable."""

from __future__ import annotations

import numpy as np
from scipy import fft, ndimage, stats

from dnanalyze.analyzers.spectra.location import located
from dnanalyze.robust import robust_deviation
from dnanalyze.significance import CERTAIN

# Times the median power of an octave, which one bin of white noise in 2^n is n times above: about
# 29, as rare as `CERTAIN`.
STRENGTH = -float(np.log2(2 * stats.norm.sf(CERTAIN)))
LEAKING = np.pi**2  # a line of so many times the strength still exceeds it one bin away
MOST_TONES = 16  # a bound on the time: harmonics of a few interferences


def robust_sd(values: np.ndarray) -> float:
    """Standard deviation of the core of a distribution."""
    return centre_and_sd(values)[1]


def centre_and_sd(values: np.ndarray, sample: int = 32_768) -> tuple[float, float]:
    """Median and robust standard deviation, of about ``sample`` of the values."""
    some = values.reshape(-1)[:: max(1, values.size // sample)]
    middle = np.median(some)
    return float(middle), robust_deviation(some, float(middle))


def clipped(image: np.ndarray, sigmas: float = 3.0) -> np.ndarray:
    """Values beyond ``sigmas`` robust sd pulled in, about the median."""
    middle, sd = centre_and_sd(image, 8192)
    return np.clip(image, np.float32(middle - sigmas * sd), np.float32(middle + sigmas * sd))


def without_transients(stack: np.ndarray, noise: float) -> np.ndarray:
    """Values far from the pixel's median over time replaced by it: hits and blinking.

    As given where there are fewer than 3 frames.
    """
    if stack.shape[0] < 3:
        return stack
    middle = np.sort(stack, axis=0)[stack.shape[0] // 2]
    return np.where(np.abs(stack - middle) > np.float32(CERTAIN * noise), middle, stack)


def without_lines(image: np.ndarray) -> np.ndarray:
    """Less the mean of each row and each column of the clipped image: hot pixels do not pull."""
    core = clipped(image)
    rows = core.mean(axis=1, keepdims=True)
    core -= rows
    return image - rows - core.mean(axis=0, keepdims=True)


def without_shading(image: np.ndarray, tile: int = 32) -> np.ndarray:
    """Less lines and less a bilinear surface through the medians of tiles, (rows, columns)."""
    flat = without_lines(image)
    h, w = flat.shape
    ny, nx = max(1, h // tile), max(1, w // tile)
    trimmed = flat[: h // ny * ny, : w // nx * nx]
    blocks = trimmed.reshape(ny, trimmed.shape[0] // ny, nx, trimmed.shape[1] // nx)
    medians = np.median(blocks[:, ::2, :, ::2], axis=(1, 3))
    y = np.clip((np.arange(h) + 0.5) * ny / h - 0.5, 0, ny - 1)
    x = np.clip((np.arange(w) + 0.5) * nx / w - 0.5, 0, nx - 1)
    surface = ndimage.map_coordinates(medians, np.meshgrid(y, x, indexing="ij"), order=1)
    return flat - surface.astype(np.float32)


def pair_differences(stack: np.ndarray) -> np.ndarray:
    """Differences of disjoint pairs of frames over sqrt 2, lines removed: (pairs, rows, columns).

    The fixed pattern cancels; what is left of two independent frames has one frame's temporal
    noise.
    """
    pairs = zip(stack[:-1:2], stack[1::2], strict=False)
    return np.stack([without_lines((b - a) * np.float32(np.sqrt(0.5))) for a, b in pairs])


def without_tones(image: np.ndarray) -> np.ndarray:
    """Less the spectral lines (hum), which are those of its core.

    A bright pixel or a particle track adds power to all bins; bins set to zero for that would take
    a pattern over the whole image away.

    A line between two bins leaks into all others, its power falling with the square of the distance
    in bins. One whose leakage would be left is first subtracted as the sinusoid that it is.
    """
    core = rest = clipped(image)
    for _ in range(MOST_TONES):
        spectrum, ratio = _spectrum_and_ratio(rest)
        at = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
        if ratio[at] < STRENGTH * LEAKING:
            break
        less = _without_sinusoid(rest, fft.fftfreq(rest.shape[0])[at[0]], at[1] / rest.shape[1])
        if _spectrum_and_ratio(less)[1][at] > ratio[at] / 4:
            break  # a broad line: less than half of its amplitude is one sinusoid
        rest = less
    else:
        spectrum, ratio = _spectrum_and_ratio(rest)
    lines = ratio > STRENGTH
    if lines.any():
        spectrum[lines] = 0
        rest = fft.irfft2(spectrum, s=image.shape).astype(image.dtype)
    return image - (core - rest)


def _spectrum_and_ratio(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Transform of an image, and the power of each bin over the median of its octave.

    Of frequencies below 2^-6 cycles/pixel, which shading fills, the ratio is 0.
    """
    h, w = image.shape
    spectrum = fft.rfft2(image)
    power = spectrum.real**2 + spectrum.imag**2
    rho = np.hypot(fft.fftfreq(h)[:, None], fft.rfftfreq(w)[None])
    octave = np.ceil(np.log2(np.maximum(rho, 1e-9))).astype(int)
    ratio = np.zeros(power.shape)
    for o in range(-5, 1):
        here = octave == o
        if here.any():
            ratio[here] = power[here] / max(float(np.median(power[here])), 1e-30)
    return spectrum, ratio


def _without_sinusoid(image: np.ndarray, v: float, u: float) -> np.ndarray:
    """Less the sinusoid of most energy near a mode (cycles/pixel, down the rows and along them)."""
    centred = image - image.mean()
    place = located([centred], u, v, 1.0)
    h, w = image.shape
    down, along = (
        np.exp(2j * np.pi * place.v * np.arange(h)),
        np.exp(2j * np.pi * place.u * np.arange(w)),
    )
    wave = np.outer(down, along).ravel()
    parts = np.stack([wave.real, wave.imag])
    # at 0.5 cycles/pixel along both axes the sine is 0
    amplitudes = np.linalg.pinv(parts @ parts.T, rcond=1e-9) @ (parts @ centred.ravel())
    return image - (amplitudes @ parts).reshape(h, w).astype(image.dtype)
