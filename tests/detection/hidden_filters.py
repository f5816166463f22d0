"""Filters that hide in raw frames, written independently of the model's effects.

Each takes a stack (frames, rows, columns) of integers and returns one: the output is rounded again.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import ndimage

Stack = np.ndarray
RING8 = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], bool)
RING24 = np.ones((5, 5), bool)
RING24[2, 2] = False


def noise_of(frame: np.ndarray) -> float:
    """Robust standard deviation of next-but-one differences along rows, DN."""
    d = np.diff(frame[:, ::2].astype(np.float32), axis=1)
    return max(0.5, float(1.4826 * np.median(np.abs(d)) / np.sqrt(2)))


def each(filter_frame: Callable[[np.ndarray], np.ndarray]) -> Callable[[Stack], Stack]:
    """Apply frame by frame, round."""

    def run(stack: Stack) -> Stack:
        return np.stack([_round(filter_frame(f.astype(np.float32)), stack.dtype) for f in stack])

    return run


def in_planes(run: Callable[[Stack], Stack]) -> Callable[[Stack], Stack]:
    """The same within each colour of a Bayer mosaic."""

    def mosaic(stack: Stack) -> Stack:
        out = np.empty_like(stack)
        for p in range(4):
            block = (slice(None), slice(p // 2, None, 2), slice(p % 2, None, 2))
            out[block] = run(np.ascontiguousarray(stack[block]))
        return out

    return mosaic


def dynamic_dpc(sigmas: float = 4.0) -> Callable[[Stack], Stack]:
    """Replace by the neighbours' median where a pixel stands out of their maximum by a
    threshold.
    """

    def run(f: np.ndarray) -> np.ndarray:
        threshold = sigmas * noise_of(f)
        top = ndimage.maximum_filter(f, footprint=RING8)
        middle = ndimage.median_filter(f, footprint=RING8)
        return np.where(f > top + threshold, middle, f)

    return each(run)


def dynamic_dpc_median(sigmas: float = 4.0) -> Callable[[Stack], Stack]:
    """Replace by the 3x3 median where a pixel departs from it, up or down, by a threshold."""

    def run(f: np.ndarray) -> np.ndarray:
        middle = ndimage.median_filter(f, size=3)
        return np.where(np.abs(f - middle) > sigmas * noise_of(f), middle, f)

    return each(run)


def clamp(footprint: np.ndarray = RING8) -> Callable[[Stack], Stack]:
    """No pixel above its neighbours' maximum ("star eater")."""
    return each(lambda f: np.minimum(f, ndimage.maximum_filter(f, footprint=footprint)))


def ratio_rule(ratio: float, pedestal: float, plus: float = 0.0, footprint: np.ndarray = RING8):
    """Replace by the neighbours' mean where the net signal exceeds ratio x their maximum + plus."""

    def run(f: np.ndarray) -> np.ndarray:
        net = f - pedestal
        top = np.maximum(ndimage.maximum_filter(net, footprint=footprint), 0)
        mean = ndimage.convolve(f, footprint.astype(np.float32) / footprint.sum())
        return np.where(net > ratio * top + plus, mean, f)

    return each(run)


def static_dpc(ppm: float = 500.0, seed: int = 0) -> Callable[[Stack], Stack]:
    """A factory list of sites, each replaced by the mean of its 4 neighbours."""

    def run(f: np.ndarray) -> np.ndarray:
        sites = np.random.default_rng(seed).random(f.shape) < ppm * 1e-6
        cross = np.array([[0, 1, 0], [1, 0, 1], [0, 1, 0]], np.float32) / 4
        return np.where(sites, ndimage.convolve(f, cross), f)

    return each(run)


def median(share: float = 0.5) -> Callable[[Stack], Stack]:
    """3x3 median, blended."""
    return each(lambda f: (1 - share) * f + share * ndimage.median_filter(f, size=3))


def gaussian(sigma: float = 0.5, share: float = 0.5) -> Callable[[Stack], Stack]:
    """Gaussian blur, blended."""
    return each(lambda f: (1 - share) * f + share * ndimage.gaussian_filter(f, sigma))


def bilateral(share: float = 0.5, reach: int = 2, sigmas: float = 2.0) -> Callable[[Stack], Stack]:
    """Bilateral filter, range of ``sigmas`` noise of the frame, blended."""

    def run(f: np.ndarray) -> np.ndarray:
        width = sigmas * noise_of(f)
        total = np.zeros_like(f)
        weight = np.zeros_like(f)
        padded = np.pad(f, reach, mode="reflect")
        for dy in range(2 * reach + 1):
            for dx in range(2 * reach + 1):
                g = padded[dy : dy + f.shape[0], dx : dx + f.shape[1]]
                distance = ((dy - reach) ** 2 + (dx - reach) ** 2) / (2 * 1.5**2)
                w = np.exp(-distance - (g - f) ** 2 / (2 * width**2))
                total += w * g
                weight += w
        return (1 - share) * f + share * total / weight

    return each(run)


def nlm(strength: float = 0.8) -> Callable[[Stack], Stack]:
    """Non-local means of scikit-image."""
    from skimage.restoration import denoise_nl_means

    def run(f: np.ndarray) -> np.ndarray:
        s = noise_of(f)
        return denoise_nl_means(
            f, patch_size=5, patch_distance=5, h=strength * s, sigma=s, preserve_range=True
        )

    return each(run)


def wavelet(sigmas: float = 1.0, name: str = "db2", levels: int = 3) -> Callable[[Stack], Stack]:
    """Soft shrinkage of PyWavelets coefficients."""
    import pywt

    def run(f: np.ndarray) -> np.ndarray:
        t = sigmas * noise_of(f)
        parts = pywt.wavedec2(f, name, level=levels, mode="periodization")
        kept = [parts[0]] + [
            tuple(pywt.threshold(d, t, mode="soft") for d in level) for level in parts[1:]
        ]
        return pywt.waverec2(kept, name, mode="periodization")[: f.shape[0], : f.shape[1]]

    return each(run)


def recursive(memory: float = 0.2) -> Callable[[Stack], Stack]:
    """y_n = (1 - memory) x_n + memory y_(n-1)."""

    def run(stack: Stack) -> Stack:
        out = np.empty(stack.shape, np.float32)
        out[0] = stack[0]
        for n in range(1, len(stack)):
            out[n] = (1 - memory) * stack[n] + memory * out[n - 1]
        return _round(out, stack.dtype)

    return run


FILTERS: dict[str, tuple[str, Callable[[Stack], Stack]]] = {
    "dynamic DPC, 4 sigma above max8": ("dpc", dynamic_dpc()),
    "dynamic DPC, 4 sigma from median": ("dpc", dynamic_dpc_median()),
    "clamp to neighbours": ("dpc", clamp()),
    "static DPC, 500 ppm": ("dpc", static_dpc()),
    "median 3x3, half": ("denoise", median()),
    "bilateral, half": ("denoise", bilateral()),
    "NLM": ("denoise", nlm()),
    "wavelet, 1 sigma": ("denoise", wavelet()),
    "Gaussian .5, half": ("denoise", gaussian()),
    "recursive, 20 %": ("temporal_denoise", recursive()),
}


def _round(frame: np.ndarray, dtype: np.dtype) -> np.ndarray:
    if np.issubdtype(dtype, np.integer):
        info = np.iinfo(dtype)
        return np.clip(np.round(frame), info.min, info.max).astype(dtype)
    return frame.astype(dtype)
