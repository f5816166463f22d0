"""Fields of random numbers from a 64-bit key and the pixel's index, and the noise made of them.

The word of a pixel is the SplitMix64 finaliser of key + golden ratio x (index + 1), where index
is row x width + column in the full frame. A uniform deviate is (word + 1/2) / 2^32, a normal one
the inverse of the normal distribution function there: both fields of one key rise together.
The kernels are imported when first drawn from: the compiler is slow to import.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

import numpy as np

from dnanalyze.loaders.captures import Window

_Function = TypeVar("_Function", bound=Callable[..., Any])

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)


def bits(key: int, window: Window, width: int) -> np.ndarray:
    """uint32 words, one a pixel of ``window`` in a frame ``width`` wide."""
    from dnanalyze.model import kernels

    out = np.empty(window.shape, np.int32)
    kernels.fill_bits(np.uint64(key), window.top, window.left, width, out)
    return out.view(np.uint32)


def uniform(key: int, window: Window, width: int) -> np.ndarray:
    """Uniform deviates in (0, 1), float32, with full relative precision towards 0."""
    from dnanalyze.model import kernels

    out = np.empty(window.shape, np.float32)
    kernels.fill_uniform(np.uint64(key), window.top, window.left, width, out)
    return out


def normal(key: int, window: Window, width: int) -> np.ndarray:
    """Standard normal deviates, float32; absolute error below 2e-6, tails to 6.3."""
    from dnanalyze.model import kernels

    out = np.empty(window.shape, np.float32)
    kernels.fill_normal(np.uint64(key), window.top, window.left, width, out)
    return out


def bits_at(key: int, index: np.ndarray) -> np.ndarray:
    """uint32 words of the pixels of the given index, any shape."""
    with np.errstate(over="ignore"):
        z = np.uint64(key) + (np.asarray(index).astype(np.uint64) + np.uint64(1)) * _GOLDEN
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        z = z ^ (z >> np.uint64(31))
    return (z >> np.uint64(32)).astype(np.uint32)


def uniform_at(key: int, index: np.ndarray) -> np.ndarray:
    """Uniform deviates of the pixels of the given index; the same as in the field."""
    unit = (bits_at(key, index).astype(np.float32) + np.float32(0.5)) * np.float32(2.0**-32)
    return np.minimum(unit, np.float32(1 - 2.0**-24))


def recordable(function: _Function) -> _Function:
    """A signal that is only recorded (`dnanalyze.model.gpu.tape`) notes the call instead."""

    @wraps(function)
    def call(signal: Any, *arguments: Any) -> Any:
        note = getattr(signal, "note", None)
        if note is not None:
            return note(function.__name__, *arguments)
        return function(signal, *arguments)

    return call  # type: ignore[return-value]


@recordable
def add_normal(
    signal: np.ndarray, scale: float, key: int, window: Window, width: int
) -> np.ndarray:
    """``signal`` + ``scale`` x the key's normal field, in place if possible."""
    from dnanalyze.model import kernels

    signal = _ready(signal)
    kernels.add_normal(np.uint64(key), window.top, window.left, width, np.float32(scale), signal)
    return signal


@recordable
def add_scaled_normal(
    signal: np.ndarray,
    offset: np.ndarray,
    scale: np.ndarray,
    factor: float,
    key: int,
    window: Window,
    width: int,
) -> np.ndarray:
    """``signal`` + ``offset`` + ``factor`` x ``scale`` x normal; offset, scale float32 fields."""
    from dnanalyze.model import kernels

    signal = _ready(signal)
    kernels.add_scaled_normal(
        np.uint64(key), window.top, window.left, width, offset, scale, np.float32(factor), signal
    )
    return signal


@recordable
def counts(signal: np.ndarray, dn_per_e: float, key: int, window: Window, width: int) -> np.ndarray:
    """K Pois(max(signal, 0)/K) + min(signal, 0), K = ``dn_per_e``; in place if possible."""
    from dnanalyze.model import kernels

    signal = _ready(signal)
    kernels.replace_by_counts(
        np.uint64(key), window.top, window.left, width, np.float32(dn_per_e), signal
    )
    return signal


def lognormal(
    key: int, mu: float, delta: float, phi: float, window: Window, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and norm, float32, of the paper's random kernel on the seed L = exp(mu + delta z).

    mean = phi sum L + (1 - 9 phi) L, norm = sqrt(sum L^2), sums over 3x3, edges repeated.
    """
    from dnanalyze.model import kernels

    mean, norm = np.empty(window.shape, np.float32), np.empty(window.shape, np.float32)
    numbers = np.float32(mu), np.float32(delta), np.float32(phi)
    kernels.fill_lognormal(np.uint64(key), window.top, window.left, width, *numbers, mean, norm)
    return mean, norm


@recordable
def add_lognormal(
    signal: np.ndarray,
    mu: float,
    delta: float,
    phi: float,
    sigma: float,
    keys: tuple[int, int],
    window: Window,
    width: int,
) -> np.ndarray:
    """``signal`` + mean + sigma x norm x normal in one pass; keys of the seed and the normal."""
    from dnanalyze.model import kernels

    signal = _ready(signal)
    seed, taps = (np.uint64(k) for k in keys)
    a, b, c, d = (np.float32(x) for x in (mu, delta, phi, sigma))
    kernels.add_lognormal(seed, taps, window.top, window.left, width, a, b, c, d, signal)
    return signal


@recordable
def share_with_neighbours(
    signal: np.ndarray, edge: float, corner: float, uneven: float = 0.0
) -> np.ndarray:
    """3x3 weights ``edge``, ``corner``, the rest in the centre; the frame's edge is repeated.

    ``uneven``: added to the weight along the row, taken off that along the column.
    """
    from dnanalyze.model import kernels

    signal = _ready(signal)
    out = np.empty_like(signal)
    weights = np.float32(edge), np.float32(corner), np.float32(uneven)
    kernels.share_with_neighbours(signal, *weights, out)
    return out


def rank(values: np.ndarray, levels: np.ndarray, near: int) -> np.ndarray:
    """How many of the ascending ``levels`` each value reaches; level k lies near ``near`` + k."""
    from dnanalyze.model import kernels

    out = values.astype(np.float32)
    kernels.replace_by_rank(levels, near, out)
    return out


def _ready(signal: np.ndarray) -> np.ndarray:
    """As the kernels are compiled for: float32, rows one after another."""
    return np.ascontiguousarray(signal, np.float32)
