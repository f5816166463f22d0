"""Take away what belongs to rows, columns and large scales, so that pixels are exchangeable."""

from __future__ import annotations

import numpy as np

from dnanalyze.robust import robust_deviation

# Of white noise one bin in 1e9 is 30 times above the median: 2^-30.
STRENGTH = 30.0
LEAKING = 10.0  # pi^2: a line of so many times the strength still exceeds it one bin away
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


def without_tones(image: np.ndarray) -> np.ndarray:
    """Less the spectral lines (hum), which are those of its core.

    A bright pixel or a particle track adds power to all bins; bins set to zero for that would take
    a pattern over the whole image away.
    """
    core = clipped(image)
    return image - (core - _without_tones(core))


def _without_tones(image: np.ndarray, strength: float = STRENGTH) -> np.ndarray:
    """Less the bins ``strength`` times above the median of their octave.

    A line between two bins leaks into all others, its power falling with the square of the distance
    in bins. One whose leakage would be left is first subtracted as the sinusoid that it is.
    """
    for _ in range(MOST_TONES):
        spectrum, ratio = _spectrum_and_ratio(image)
        at = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
        if ratio[at] < strength * LEAKING:
            break
        u, v = np.fft.fftfreq(image.shape[0])[at[0]], at[1] / image.shape[1]
        rest = _without_sinusoid(image, float(u), float(v))
        if _spectrum_and_ratio(rest)[1][at] > ratio[at] / 4:
            break  # a broad line: less than half of its amplitude is one sinusoid
        image = rest
    spectrum, ratio = _spectrum_and_ratio(image)
    lines = ratio > strength
    if not lines.any():
        return image
    from scipy import fft

    spectrum[lines] = 0
    return fft.irfft2(spectrum, s=image.shape).astype(image.dtype)


def _spectrum_and_ratio(image: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Transform of an image, and the power of each bin over the median of its octave.

    Of frequencies below 2^-6 cycles/pixel, which shading fills, the ratio is 0.
    """
    from scipy import fft

    h, w = image.shape
    spectrum = fft.rfft2(image)
    power = spectrum.real**2 + spectrum.imag**2
    rho = np.hypot(np.fft.fftfreq(h)[:, None], np.fft.rfftfreq(w)[None])
    octave = np.ceil(np.log2(np.maximum(rho, 1e-9))).astype(int)
    ratio = np.zeros(power.shape)
    for o in range(-5, 1):
        here = octave == o
        if here.any():
            ratio[here] = power[here] / max(float(np.median(power[here])), 1e-30)
    return spectrum, ratio


def _without_sinusoid(image: np.ndarray, u: float, v: float) -> np.ndarray:
    """Less the sinusoid near a frequency (cycles/pixel, down the rows and along them).

    The frequency is refined by the phase from block to block of the image times the conjugate wave
    (Kay 1989, in two dimensions); amplitude and phase are those of least squares.
    """
    h, w = image.shape
    y, x = np.arange(h), np.arange(w)
    centred = image - image.mean()
    for size in (min(h, w) // 8, min(h, w) // 3):
        rows, columns = h // size, w // size
        down = np.exp(-2j * np.pi * u * y)[: rows * size].reshape(rows, size)
        along = np.exp(-2j * np.pi * v * x)[: columns * size].reshape(columns, size)
        blocks = centred[: rows * size, : columns * size].reshape(rows, size, columns, size)
        phasors = np.einsum("asbt,as,bt->ab", blocks, down, along, optimize=True)
        u += float(np.angle(np.sum(phasors[1:] * phasors[:-1].conj()))) / (2 * np.pi * size)
        v += float(np.angle(np.sum(phasors[:, 1:] * phasors[:, :-1].conj()))) / (2 * np.pi * size)
    wave = np.outer(np.exp(2j * np.pi * u * y), np.exp(2j * np.pi * v * x)).ravel()
    parts = np.stack([wave.real, wave.imag])
    # at 0.5 cycles/pixel along both axes the sine is 0
    amplitudes = np.linalg.pinv(parts @ parts.T, rcond=1e-9) @ (parts @ centred.ravel())
    return image - (amplitudes @ parts).reshape(h, w).astype(image.dtype)
