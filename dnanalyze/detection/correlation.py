"""Correlation of the temporal noise between neighbours, and how much of it crosstalk can make.

Charge crosstalk smooths the dark charge and its shot noise, never the read noise, which arises
after it. So its correlation grows with the share of shot noise, and cannot exceed that of the
largest crosstalk that sensors have; a filter smooths read noise as well.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy import signal

from dnanalyze.detection.extremes import exceedance
from dnanalyze.detection.flatten import clipped
from dnanalyze.detection.spectrum import EDGES, OctaveSpectrum, octave_log_power
from dnanalyze.thermal import arrhenius

LARGEST_CROSSTALK = 0.02  # share to each of the 8 neighbours
DECAY = 2.5  # of rho(1), and of its steps, for which 1/f noise over the scan may account
# rho(1) / rho(3) of a field of power rho^-a: 6.2 at a = .6, less for steeper ones. What shallower
# ones leave stays below .02 of their own variance.
DECAY_OVER_FIELD = 6.2
LEAST_EA_EV = 0.40  # below the activation energy of any bulk dark current


@dataclass(frozen=True)
class LagCorrelation:
    """Correlation coefficients of an image with itself, shifted."""

    # At lags 1, 2 and 3.
    along_rows: tuple[float, float, float]
    along_columns: tuple[float, float, float]
    diagonal: float  # at (1, 1)
    se: float  # standard error of each for white noise
    variance: float  # of the core of the distribution, DN^2

    @property
    def short_range(self) -> float:
        """Correlation that is gone two and three pixels away in rows and in columns: the lesser of
        rho(1) - max(2.5 rho(2), 6.2 rho(3)), next to none for 1/f noise over the scan or the field.

        A readout that is slow along one of them is left out.
        """
        return min(_gone(self.along_rows), _gone(self.along_columns))

    @property
    def short_range_error(self) -> float:
        """Standard error of the short range, and all but that of its variant under flicker."""
        return self.se * max(_error(self.along_rows), _error(self.along_columns))

    @property
    def short_range_under_flicker(self) -> float:
        """The same where strong 1/f noise over the scan buries that of a filter in one direction.

        There the steps (rho(1) - rho(2)) - 2.5 (rho(2) - rho(3)) count too, as long as the other
        direction, which such noise leaves alone, shows its own. For noise only: a fixed pattern
        has steps of its own.
        """
        rows, columns = self.along_rows, self.along_columns
        plain = _gone(rows), _gone(columns)
        steps = [
            max(one, _gone((r[0] - max(r[1], 0.0), r[1] - r[2], 0.0)))
            for one, r in zip(plain, (rows, columns), strict=True)
        ]
        return max(min(steps[0], plain[1]), min(plain[0], steps[1]))


def _gone(near_and_far: tuple[float, ...]) -> float:
    near, far, farther = near_and_far
    return near - max(DECAY * far, DECAY_OVER_FIELD * farther, 0.0)


def _error(near_and_far: tuple[float, ...]) -> float:
    """Standard error of `_gone`, in those of a coefficient."""
    _, far, farther = near_and_far
    return math.hypot(1.0, DECAY_OVER_FIELD if DECAY_OVER_FIELD * farther > DECAY * far else DECAY)


def lag_correlation(images: np.ndarray) -> LagCorrelation:
    """From images (n, rows, columns), outliers pulled in."""
    sums = np.zeros(8)
    for image in images:
        x = clipped(image)
        x = x - x.mean()
        along = [np.mean(x[:, lag:] * x[:, : x.shape[1] - lag]) for lag in range(4)]
        down = [np.mean(x[lag:] * x[:-lag]) for lag in (1, 2, 3)]
        across = (np.mean(x[1:, 1:] * x[:-1, :-1]) + np.mean(x[1:, :-1] * x[:-1, 1:])) / 2
        sums += [*along, *down, across]
    variance = sums[0] / len(images)
    r = sums[1:] / sums[0] if sums[0] > 0 else np.zeros(7)
    return LagCorrelation(
        tuple(r[0:3]), tuple(r[3:6]), float(r[6]), 1 / np.sqrt(images.size), float(variance)
    )  # fmt: skip


def crosstalk_kernel(phi: float) -> np.ndarray:
    """The 3x3 kernel that gives a share phi to each of 8 neighbours."""
    taps = np.full((3, 3), phi)
    taps[1, 1] = 1 - 8 * phi
    return taps


class CrosstalkBound(NamedTuple):
    """The most that the largest crosstalk does to pure shot noise, statistic by statistic."""

    short_range: float
    concavity: float
    extremes: float


@cache
def largest_crosstalk(apart: int = 1) -> CrosstalkBound:
    """From the kernel's autocorrelation and spectrum, of every ``apart``-th row and column.

    Pixels of one colour of a mosaic are two apart: next to none of a 3x3 kernel is left.
    """
    taps = np.pad(crosstalk_kernel(LARGEST_CROSSTALK), 1)
    shared = signal.correlate2d(taps, taps)
    middle = shared.shape[0] // 2
    seen = shared[middle % apart :: apart, middle % apart :: apart] / shared[middle, middle]
    along = np.append(seen[seen.shape[0] // 2, seen.shape[1] // 2 :], 0.0)
    spectrum = OctaveSpectrum(octave_log_power(seen), np.full(EDGES.size - 1, 1.0))
    short_range, concavity = _gone((along[1], along[2], 0.0)), spectrum.concavity()[0]
    return CrosstalkBound(short_range, concavity, _fewer_extremes(apart))


def _fewer_extremes(apart: int) -> float:
    """1 - 9 P of shot noise under the largest crosstalk, by simulation: good to .001."""
    white = np.random.default_rng(0).standard_normal((1024, 1024), np.float32)
    noise = signal.fftconvolve(white, crosstalk_kernel(LARGEST_CROSSTALK), mode="valid")
    return 1.0 - exceedance(noise[None, ::apart, ::apart]).extremes


def shot_share(
    variance: float, temperature_c: float | None, others: list[tuple[float, float | None]]
) -> float:
    """Upper bound on the share of shot noise in the temporal variance at a temperature.

    Between T and a warmer T' shot noise grows by at least g = exp(Ea/k (1/T - 1/T')); so it is at
    most (V' - V)/(g - 1) at T. Ea is taken low: from three temperatures where there are, else the
    least. ``others``: variances, DN^2, and temperatures, C, at the same exposure and gain. 1 where
    nothing is known.
    """
    if temperature_c is None or variance <= 0:
        return 1.0
    share = 1.0
    warmer = sorted(
        (t, v)
        for v, t in others
        if t is not None and t > temperature_c + 3 and v >= 0.98 * variance
    )
    ea = _activation(temperature_c, variance, warmer)
    for there, other in warmer:
        grown = arrhenius(there, temperature_c, ea) - 1
        share = min(share, (other - variance) / variance / grown)
    return float(np.clip(share, 0.0, 1.0))


def _activation(cold_c: float, variance: float, warmer: list[tuple[float, float]]) -> float:
    """A safe, low activation energy: what three variances V = s^2 + A exp(-Ea/kT) give, less .1
    eV.
    """
    if len(warmer) < 2 or warmer[0][1] <= 1.05 * variance:
        return LEAST_EA_EV
    (near, at_near), (far, at_far) = warmer[:2]
    ratio = (at_far - variance) / (at_near - variance)
    energies = np.linspace(LEAST_EA_EV, 1.2, 81)
    grown = [[arrhenius(t, cold_c, ea) - 1 for t in (far, near)] for ea in energies]
    predicted = [there / here for there, here in grown]
    return max(LEAST_EA_EV, float(np.interp(ratio, predicted, energies)) - 0.1)
