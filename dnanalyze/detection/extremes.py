"""How often a pixel is the largest, or the smallest, of its neighbourhood.

For exchangeable pixels P(x above its n neighbours) = 1/(n + 1) exactly, whatever the marginal. Any
smoothing makes local extremes rarer; a correction of hot pixels alone makes only the maxima rarer.
A filter that acts on some rows only, such as those with phase-detection pixels, shows in the
extremes among neighbours of the same row, folded over periods of rows: two columns away, of the
same colour on a mosaic, and one column away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from dnanalyze.detection.ring import ring_maximum, ring_minimum
from dnanalyze.robust import robust_deviation

PLACES = 9  # a pixel and its 8 neighbours
# Standard deviation of the mean share of maxima and minima times sqrt(pixels), by simulation. Of
# maxima alone it is .158: maxima of neighbours exclude one another, those two pixels apart have
# P = 2 / (9 m) for rings of m pixels together.
EXTREMES_SD = 0.118
# Turning points of n exchangeable values have a variance of 16 n / 90 (Bienayme 1874); relative to
# their share of 2/3.
TURNING_SD = math.sqrt(16 / 90) * 1.5
MEDIAN_SD = math.sqrt(math.pi / 2)  # of a median over that of the mean of normal values
PERIODS = range(2, 17)  # pixels, of row and column structure: up to 16 outputs
LEAST_ROWS = 6  # of a phase


@dataclass(frozen=True)
class Exceedance:
    """Counts of pixels above, and below, all 8 neighbours, of ``pixels``."""

    above: int
    below: int
    pixels: int

    @property
    def extremes(self) -> float:
        """Local extremes over those of exchangeable pixels; 1 for no filter."""
        return PLACES * (self.above + self.below) / (2 * self.pixels)

    @property
    def se(self) -> float:
        """Standard error of ``extremes`` for exchangeable pixels."""
        return PLACES * EXTREMES_SD / math.sqrt(self.pixels)


def exceedance(images: np.ndarray) -> Exceedance:
    """Count in images (n, rows, columns) without ties."""
    above = below = pixels = 0
    for image in images:
        inner = image[1:-1, 1:-1]
        above += int(np.count_nonzero(inner > ring_maximum(image)))
        below += int(np.count_nonzero(inner < ring_minimum(image)))
        pixels += inner.size
    return Exceedance(above, below, pixels)


@dataclass(frozen=True)
class RowPhase:
    """The row phase that departs most."""

    # Rows; phase counts from the first row.
    period: int
    phase: int
    # 1 - (local extremes in those rows over the others'); positive where they are smoother.
    effect: float
    z: float  # in standard errors
    one_sided: bool  # only the maxima are rarer: a correction of hot pixels, not a smoothing
    tried: int  # phases looked at
    freedom: float = np.inf  # degrees of freedom of the scatter of the rows

    @property
    def p(self) -> float:
        """Of this phase alone."""
        return float(stats.t.sf(self.z, self.freedom))


def row_phase(images: np.ndarray) -> RowPhase:
    """Look at images (n, rows, columns) of noise without ties."""
    rows = images.shape[1]
    best = RowPhase(1, 0, 0.0, 0.0, False, 0)
    tried = 0
    for step in (1, 2):
        left, here, right = (
            images[:, :, : -2 * step],
            images[:, :, step:-step],
            images[:, :, 2 * step :],
        )
        above, below = (here > left) & (here > right), (here < left) & (here < right)
        maxima, minima = (3 * np.mean(x, axis=(0, 2)) for x in (above, below))
        share = (maxima + minima) / 2
        chance = TURNING_SD / math.sqrt(here[:, 0].size)
        scatter = max(robust_deviation(share), chance)
        for period in PERIODS:
            for phase in range(period):
                inside = np.arange(rows) % period == phase
                n = int(inside.sum())
                if n < LEAST_ROWS:
                    continue
                tried += 1
                fewer, up, down = (
                    float(np.median(s[~inside]) - np.median(s[inside]))
                    for s in (share, maxima, minima)
                )
                z = fewer / (MEDIAN_SD * scatter * math.sqrt(1 / n + 1 / (rows - n)))
                if z > best.z:
                    effect = fewer / float(np.median(share[~inside]))
                    best = RowPhase(period, phase, effect, z, up > 3 * abs(down), 0)
    # a scatter from the median of N absolute deviations has a relative variance of 1.36 / N
    return replace(best, tried=tried, freedom=rows / 2.7)
