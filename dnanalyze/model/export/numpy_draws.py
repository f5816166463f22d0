"""The random fields of `dnanalyze.model.draws` in NumPy alone: the same numbers, more slowly.

This file is the source of what an exported simulator draws from.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from dnanalyze.loaders.captures import Window

GOLDEN = 0x9E3779B97F4A7C15
# log-free tail variable to normal deviate, as in the compiled kernels
NORMAL = (
    2.9951517581939697, 2.347184419631958, 0.5876625180244446, 0.09259991347789764,
    0.23363545536994934, 0.09295359253883362, -0.06048748269677162, 0.006783090531826019,
    0.05257555842399597, 0.0007386205834336579, -0.017163332551717758,
    0.0020622294396162033, 0.00426151417195797,
)  # fmt: skip
TAIL = (1.930770993232727, 29.307710647583008, 10.0)
INVERTED_BELOW = 10.0


def bits_at(key: int, index: np.ndarray) -> np.ndarray:
    """uint32 words of the pixels of the given index: SplitMix64 of key + golden ratio x index."""
    with np.errstate(over="ignore"):
        z = np.uint64(key) + (np.asarray(index).astype(np.uint64) + np.uint64(1)) * np.uint64(
            GOLDEN
        )
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        z = z ^ (z >> np.uint64(31))
    return (z >> np.uint64(32)).astype(np.uint32)


def words(key: int, window: Window, width: int) -> np.ndarray:
    """uint32 words of a window of a frame ``width`` wide."""
    rows = np.arange(window.top, window.bottom)[:, None]
    columns = np.arange(window.left, window.right)[None, :]
    return bits_at(key, rows * width + columns)


def uniform_of(word: np.ndarray) -> np.ndarray:
    """Uniform deviates in (0, 1), float32."""
    unit = (word.astype(np.float32) + np.float32(0.5)) * np.float32(2.0**-32)
    return np.minimum(unit, np.float32(1 - 2.0**-24))


def normal_of(word: np.ndarray) -> np.ndarray:
    """Inverse normal distribution function at (word + 1/2) / 2^32, float32."""
    signed = (word.astype(np.int64) - 2**31).astype(np.float64)
    x = (signed + 0.5) * 2.0**-31
    q = 1.0 - np.abs(x)
    w = -np.log(q * (2.0 - q))
    t = TAIL[0] - TAIL[1] / (w + TAIL[2])
    p = np.zeros_like(t)
    for c in NORMAL[::-1]:
        p = p * t + c
    return (x * p).astype(np.float32)


def uniform(key: int, window: Window, width: int) -> np.ndarray:
    """Uniform field over a window."""
    return uniform_of(words(key, window, width))


def normal(key: int, window: Window, width: int) -> np.ndarray:
    """Standard normal field over a window."""
    return normal_of(words(key, window, width))


def uniform_at(key: int, index: np.ndarray) -> np.ndarray:
    """Uniform deviates of a few pixels."""
    return uniform_of(bits_at(key, index))


@njit(cache=True)
def exp(x: float) -> float:
    """e^x, for loops."""
    return math.exp(x)


def add_normal(
    signal: np.ndarray, scale: float, key: int, window: Window, width: int
) -> np.ndarray:
    """Signal plus scale times the key's normal field."""
    return signal + np.float32(scale) * normal(key, window, width)


def add_scaled_normal(
    signal: np.ndarray,
    offset: np.ndarray,
    scale: np.ndarray,
    factor: float,
    key: int,
    window: Window,
    width: int,
) -> np.ndarray:
    """Signal plus offset plus factor times scale times normal."""
    return signal + offset + np.float32(factor) * scale * normal(key, window, width)


def counts(signal: np.ndarray, dn_per_e: float, key: int, window: Window, width: int) -> np.ndarray:
    """K Pois(max(signal, 0)/K) + min(signal, 0): exact inversion below 10, else Cornish-Fisher."""
    k = np.float32(dn_per_e)
    word = words(key, window, width)
    mean = np.maximum(signal, 0) / k
    few = mean < INVERTED_BELOW
    number = many_counts(normal_of(word), np.maximum(mean, INVERTED_BELOW))
    number[few] = few_counts(word[few], mean[few])
    return k * number + np.minimum(signal, 0)


def many_counts(z: np.ndarray, lam: np.ndarray) -> np.ndarray:
    """Poisson quantiles of means from 10 on, by their cumulants less Sheppard's corrections."""
    s2 = lam - 1 / 12
    s = np.sqrt(s2)
    g1, g2 = lam / (s2 * s), (lam + 1 / 120) / (s2 * s2)
    z2 = z * z
    w = z + g1 * (z2 - 1) / 6
    w = w + z * (g2 * (z2 - 3) / 24 - g1 * g1 * (2 * z2 - 5) / 36)
    w = w + g1 / s2 * (z2 * (z2 - 6) + 3) / 120
    w = w - g1 * g2 * (z2 * (z2 - 5) + 2) / 24
    w = w + g1 * g1 * g1 * (z2 * (12 * z2 - 53) + 17) / 324
    return np.maximum(np.rint(lam + s * w), 0).astype(np.float32)


def few_counts(word: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Poisson quantiles of means below 10: the k whose tail first drops to 1 - u."""
    lam = mean.astype(np.float64)
    p = np.exp(-lam)
    above = 1.0 - p
    tail = ((~word).astype(np.float64) + 0.5) * 2.0**-32
    number = np.zeros(lam.shape, np.float32)
    for k in range(1, 64):
        bigger = tail < above
        if not bigger.any():
            break
        number += bigger
        p = p * lam / k
        above = above - p
    return number


def around(image: np.ndarray) -> list[np.ndarray]:
    """The nine shifts of a field, its edge repeated."""
    rows, columns = image.shape
    wide = np.pad(image, 1, mode="edge")
    return [wide[i : i + rows, j : j + columns] for i in range(3) for j in range(3)]


def lognormal(
    key: int, mu: float, delta: float, phi: float, window: Window, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and norm of the paper's random kernel on the seed exp(mu + delta z)."""
    light = np.exp(np.float32(mu) + np.float32(delta) * normal(key, window, width))
    near = around(light)
    share = np.float32(phi)
    mean = share * sum(near) + (np.float32(1) - np.float32(9) * share) * light
    return mean, np.sqrt(sum(n * n for n in near))


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
    """Signal plus the paper's model; keys of the seed and of the taps."""
    mean, norm = lognormal(keys[0], mu, delta, phi, window, width)
    return add_scaled_normal(signal, mean, norm, sigma, keys[1], window, width)


def share_with_neighbours(
    signal: np.ndarray, edge: float, corner: float, uneven: float = 0.0
) -> np.ndarray:
    """3x3 weights ``edge``, ``corner``, the rest in the centre; the frame's edge is repeated.

    ``uneven``: added to the weight along the row, taken off that along the column.
    """
    a, b, c, d, e, f, g, h, i = around(signal)
    side, diagonal, more = np.float32(edge), np.float32(corner), np.float32(uneven)
    centre = np.float32(1) - 4 * side - 4 * diagonal
    sides = side * (b + d + f + h) + more * (d + f - b - h)
    return centre * e + sides + diagonal * (a + c + g + i)


def rank(values: np.ndarray, levels: np.ndarray, near: int) -> np.ndarray:
    """How many of the ascending ``levels`` each value reaches, wherever they lie."""
    return np.searchsorted(levels, values, side="right").astype(np.float32)
