"""The shape of a spectrum: its slope, the corner of its rise, and its picture."""

from __future__ import annotations

import math

import numpy as np
from scipy import special

from dnanalyze.analyzers.statistics import Value

CORNER_RISE = 2.0  # the corner frequency is where the power is this many times the white floor
_PICTURE = 128  # largest side of the 2-D spectra kept for figures


def slope(f: np.ndarray, power: np.ndarray, n: np.ndarray) -> Value | None:
    """Weighted least squares of ln power on ln f."""
    good = (n >= 1) & (np.nan_to_num(power) > 0)
    if good.sum() < 3:
        return None
    x, w = np.log(f[good]), n[good]
    y = np.log(power[good]) - (special.digamma(w) - np.log(w))
    w = 1.0 / special.polygamma(1, w)
    d = x - np.average(x, weights=w)
    norm = float(w @ d**2)
    return Value(float(w @ (d * y)) / norm, 1.0 / math.sqrt(norm))


def corner(f: np.ndarray, power: np.ndarray, n: np.ndarray) -> Value | None:
    """Highest frequency at which the power is still twice the floor, the mean above 1/4 c/px."""
    good = n >= 1
    f, power, n = f[good], power[good], n[good]
    top = f > 0.25
    if not top.any() or not power[top].any():
        return None
    floor = float(np.average(power[top], weights=n[top]))
    # runs of bins with 16 modes or more, lest one mode of chance make a corner
    group = np.cumsum(n) // 16
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    total = np.add.reduceat(n, starts)
    x = np.add.reduceat(n * f, starts) / total
    y = np.add.reduceat(n * power, starts) / total / floor
    above = np.flatnonzero((y >= CORNER_RISE) & (x < 0.25))
    if not above.size or above[-1] + 1 >= x.size:
        return None
    a = int(above[-1])
    t = math.log(y[a] / CORNER_RISE) / math.log(y[a] / y[a + 1])
    step = math.log(x[a + 1] / x[a])
    return Value(float(x[a]) * math.exp(t * step), float(x[a]) * step / 2)


def picture(power: np.ndarray) -> np.ndarray:
    """Log10 of the power in at most 128 x 128 cells.

    Rows run over v from -1/2 to 1/2, columns over u from 0 to 1/2.
    """
    rows, half = power.shape
    y = np.unique(np.linspace(0, rows, _PICTURE, endpoint=False).astype(int))
    x = np.unique(np.linspace(0, half, _PICTURE, endpoint=False).astype(int))
    centred = np.fft.fftshift(np.add.reduceat(power, x, axis=1), axes=0)
    sums = np.add.reduceat(centred, y, axis=0)
    sizes = np.diff([*y, rows])[:, None] * np.diff([*x, half])
    mean = sums / sizes
    positive = mean[mean > 0]
    lowest = positive.min() if positive.size else 1.0
    return np.log10(np.maximum(mean, lowest)).astype(np.float32)
