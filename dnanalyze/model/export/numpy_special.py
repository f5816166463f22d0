"""The few functions of SciPy that effects use, in NumPy; source of exported simulators."""

from __future__ import annotations

import math
import statistics

import numpy as np


def ndtr(x: np.ndarray) -> np.ndarray:
    """Normal distribution function."""
    return 0.5 * np.vectorize(math.erfc, otypes=[float])(-np.asarray(x, float) / math.sqrt(2.0))


def ndtri(p: np.ndarray) -> np.ndarray:
    """Quantiles of the normal distribution."""
    return np.vectorize(statistics.NormalDist().inv_cdf, otypes=[float])(np.asarray(p, float))


def gammaincinv(a: float, p: np.ndarray) -> np.ndarray:
    """Quantiles of the gamma distribution of shape a; its density over ln x is summed."""
    low = (math.log(1e-11) + math.lgamma(a + 1.0)) / a  # below it lies a probability of 1e-11
    y = np.linspace(low, math.log(a + 9.0 * math.sqrt(a) + 40.0), 400_001)
    density = np.exp(a * y - np.exp(y) - math.lgamma(a))
    below = np.append(0.0, np.cumsum(density[1:] + density[:-1]))
    found: np.ndarray = np.exp(np.interp(p, below / below[-1], y))
    return found


def pdtrc(k: np.ndarray, mean: float) -> np.ndarray:
    """Probability that a Poisson count exceeds k."""
    top = int(np.max(k)) + 1
    terms = [math.exp(-mean + i * math.log(mean) - math.lgamma(i + 1)) for i in range(top)]
    return np.clip(1.0 - np.cumsum(terms), 0.0, 1.0)[np.asarray(k)]


def pdtrik(u: float, mean: float) -> float:
    """The count at which a Poisson distribution function reaches u."""
    total, k = math.exp(-mean), 0
    while total < u and k < mean + 40 * math.sqrt(mean) + 100:
        k += 1
        total += math.exp(-mean + k * math.log(mean) - math.lgamma(k + 1))
    return float(k)


def lfilter(b: list[float], a: list[float], x: np.ndarray) -> np.ndarray:
    """Recursion y_n = x_n - a_1 y_(n-1)."""
    out = np.array(x, float)
    for n in range(1, out.size):
        out[n] -= a[1] * out[n - 1]
    return out


def correlate1d(
    image: np.ndarray, kernel: np.ndarray, axis: int, mode: str = "mirror", output: type = float
) -> np.ndarray:
    """Correlation along an axis; the frame is mirrored at its edge, which is not repeated."""
    reach = len(kernel) // 2
    pads = [(reach, reach) if i == axis else (0, 0) for i in range(2)]
    wide = np.moveaxis(np.pad(np.asarray(image, float), pads, mode="reflect"), axis, 0)
    length = image.shape[axis]
    made = sum(w * wide[i : i + length] for i, w in enumerate(kernel))
    return np.moveaxis(np.asarray(made), 0, axis).astype(output)
