"""Octave powers of the noise, and what tells a low-pass filter from 1/f noise.

White noise with any amount of 1/f falls ever more slowly towards high frequencies: ln P over
octaves is
convex. A filter is flat below its corner and falls above it: concave somewhere. Medians over the
bins of an octave ignore spectral lines (hum, taps); the axes, which hold lines' offsets, are left
out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy import fft, stats

from dnanalyze.detection.flatten import clipped

EDGES = np.array([0.004, 0.008, 0.016, 0.03, 0.06, 0.12, 0.25, 0.45, 0.7072])  # cycles/pixel
# Logarithms, of octaves
CENTRES = np.log2(EDGES[:-1] * EDGES[1:]) / 2
LEAST_BINS = 16  # of a band: the median of 16 exponential powers scatters by 36 %
MIDDLE, IN_MIDDLE = (
    slice(3, 5),
    4,
)  # octaves of the paper's ratio: .03 to .12 cycles/pixel


class Chord(NamedTuple):
    """Rise of ln P, and its error, at the second of three octaves above the line of the others."""

    octaves: tuple[int, int, int]
    rise: float
    se: float


@dataclass(frozen=True)
class OctaveSpectrum:
    """Powers of octaves of radial frequency."""

    # (octaves,), ln of the median power, about what white noise has; NaN below the frame's reach.
    log_power: np.ndarray
    se: np.ndarray  # (octaves,), standard errors

    @property
    def suppression(self) -> tuple[float, float]:
        """ln R = ln of the power above .45 over that of .03 to .12 cycles/pixel, and its error."""
        middle, weights = self.log_power[MIDDLE], self.se[MIDDLE] ** -2.0
        if not weights.any():
            return math.nan, math.inf
        level = float(np.nansum(weights * middle) / weights.sum())
        return self.log_power[-1] - level, float(np.hypot(self.se[-1], weights.sum() ** -0.5))

    @property
    def independent_chords(self) -> int:
        """Number of independent chords: about one to an inner octave.

        All chords overlap. Of white noise the largest of all has a p-value below 1e-3 in 2.7, 3.5
        and 4.0 of 1,000 draws for 5, 6 and 7 octaves.
        """
        return max(1, int(np.isfinite(self.log_power).sum()) - 2)

    def chord(self) -> Chord | None:
        """Where ln P rises most above the chord between a lower and a higher octave.

        The one taken is the largest after four standard errors are taken off.
        """
        p, s = self.log_power, self.se
        best: Chord | None = None
        for i, j, k in combinations(np.flatnonzero(np.isfinite(p)), 3):
            if p[j] > p[i] + 3 * np.hypot(s[i], s[j]):
                continue  # noise that grows up to the middle is a hump, not a low-pass filter's
            share = float(CENTRES[k] - CENTRES[j]) / float(CENTRES[k] - CENTRES[i])
            value = float(p[j] - share * p[i] - (1 - share) * p[k])
            se = float(np.sqrt(s[j] ** 2 + (share * s[i]) ** 2 + ((1 - share) * s[k]) ** 2))
            if best is None or value - 4 * se > best.rise - 4 * best.se:
                best = Chord((int(i), int(j), int(k)), value, se)
        return best

    def concavity(self) -> tuple[float, float]:
        """Largest rise of ln P above a chord, and its error; (0, infinite) without octaves.

        At most zero, but for sampling error, for white noise with 1/f noise of any strength and
        slope.
        """
        best = self.chord()
        return (0.0, np.inf) if best is None else (best.rise, best.se)


def octave_spectrum(images: np.ndarray) -> OctaveSpectrum:
    """From images (n, rows, columns) of the same noise, outliers pulled in."""
    n, h, w = images.shape
    rho, where = _bins(h, w)
    total = np.zeros(rho.shape, np.float32)
    for image in images:
        spectrum = fft.rfft2(clipped(image))
        total += spectrum.real**2 + spectrum.imag**2
    power = np.full(EDGES.size - 1, np.nan)
    se = np.full(EDGES.size - 1, np.inf)
    for band in range(power.size):
        inside = total[where == band]
        if inside.size >= LEAST_BINS and np.median(inside) > 0:
            power[band] = math.log(float(np.median(inside)) / (n * h * w))
            se[band] = _of_median(n) / math.sqrt(inside.size)
    return OctaveSpectrum(power, se)


def _of_median(n: int) -> float:
    """Standard error of ln of the median of N powers, times sqrt(N).

    The sum of n powers of Gaussian noise has a gamma distribution of shape n; a median m scatters
    by 1 / (2 f(m) sqrt(N)), f the density.
    """
    law = stats.gamma(n)
    middle = law.median()
    return float(1 / (2 * law.pdf(middle) * middle))


def _bins(h: int, w: int) -> tuple[np.ndarray, np.ndarray]:
    u = np.fft.rfftfreq(w).astype(np.float32)[None]
    v = np.abs(np.fft.fftfreq(h)).astype(np.float32)[:, None]
    rho = np.hypot(u, v)
    band = np.searchsorted(EDGES, rho, side="right") - 1
    band[(u < 1.5 / w) | (v < 1.5 / h) | (rho < EDGES[0])] = -1
    return rho, band.astype(np.int8)


def octave_log_power(shared: np.ndarray, shape: tuple[int, int] = (256, 256)) -> np.ndarray:
    """ln of the power in the octaves of noise of a small autocovariance (odd sides, in the middle).

    NaN in octaves below the reach of ``shape``.
    """
    padded = np.zeros(shape)
    padded[: shared.shape[0], : shared.shape[1]] = shared
    power = np.abs(fft.rfft2(padded))
    _, where = _bins(*shape)
    bands = [power[where == b] for b in range(EDGES.size - 1)]
    return np.array([np.log(np.median(p)) if p.size else np.nan for p in bands])
