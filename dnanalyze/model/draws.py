"""Fields of uniform and normal deviates from a key and the pixel's index (SplitMix64 finaliser)."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtri

from dnanalyze.loaders.captures import Window

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)


def bits_at(key: int, index: np.ndarray) -> np.ndarray:
    """uint32 words of the pixels whose index in the full frame (row x width + column) is given."""
    with np.errstate(over="ignore"):
        z = np.uint64(key) + (index.astype(np.uint64) + np.uint64(1)) * _GOLDEN
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        z = z ^ (z >> np.uint64(31))
    return (z >> np.uint64(32)).astype(np.uint32)


def bits(key: int, window: Window, width: int) -> np.ndarray:
    """uint32 words, one a pixel of ``window``."""
    rows = np.arange(window.top, window.bottom, dtype=np.uint64)[:, None]
    cols = np.arange(window.left, window.right, dtype=np.uint64)[None, :]
    return bits_at(key, rows * np.uint64(width) + cols)


def _uniform(words: np.ndarray) -> np.ndarray:
    return np.minimum(((words + 0.5) * 2.0**-32).astype(np.float32), np.float32(1 - 2.0**-24))


def uniform_at(key: int, index: np.ndarray) -> np.ndarray:
    """Uniform deviates in (0, 1), float32, of the pixels of the given index."""
    return _uniform(bits_at(key, index))


def uniform(key: int, window: Window, width: int) -> np.ndarray:
    """Uniform deviates in (0, 1), float32, with full relative precision towards 0."""
    return _uniform(bits(key, window, width))


def normal(key: int, window: Window, width: int) -> np.ndarray:
    """Standard normal deviates, float32, by the inverse of the distribution function."""
    return ndtri((bits(key, window, width) + 0.5) * 2.0**-32).astype(np.float32)
