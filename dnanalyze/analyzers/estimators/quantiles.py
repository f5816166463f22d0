"""Quantiles that mean the same for codes of a converter and for continuous data.

A code c stands for the interval c - 1/2 to c + 1/2; the distribution function at its ends is that
of the signal before rounding, so interpolating between them is right where no code can be.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

IQR_SIGMA = 1.3489795003921634  # interquartile range of the standard normal


def _interval(tight: float, level: float, step: float) -> float:
    """A spread that is never 0: at least what a constant of that resolution has."""
    resolution = step / 2 if step else 1e-6 * max(1.0, abs(level))
    return max(tight, resolution) / IQR_SIGMA


def median(sample: np.ndarray) -> float:
    """Middle of a sample of any shape, or of its two middle values."""
    flat = np.sort(sample, axis=None)  # which is vectorised, as selecting is not
    return float(flat[(flat.size - 1) // 2 : flat.size // 2 + 1].mean())


def in_order(sample: np.ndarray, step: float = 0.0) -> np.ndarray:
    """A sample in order, flat; on a lattice of spacing ``step`` by counting, where that is quick.

    Counting takes one pass over the sample and one over the points of the lattice. No more points
    than values: a sample of few, far apart is sorted, as is one that is on no such lattice.
    """
    from dnanalyze.analyzers.kernels.pixel_loops import tally_lattice

    flat = np.ravel(sample)
    if not step or flat.size < 2:
        return _sorted(flat)
    first, last = flat.min(), flat.max()
    if not (float(last) - float(first)) / step < flat.size:  # NaN is not
        return _sorted(flat)
    points = int((float(last) - float(first)) / step + 0.5) + 1
    levels, counts = np.zeros(points, flat.dtype), np.zeros(points, np.int64)
    if not tally_lattice(flat, float(first), step, levels, counts):
        return _sorted(flat)
    return np.repeat(levels, counts)


def _sorted(flat: np.ndarray) -> np.ndarray:
    from dnanalyze.analyzers.kernels.sorting import radix_sorted

    if flat.dtype == np.float32 and not np.isnan(flat).any():
        return np.asarray(radix_sorted(flat))
    return np.sort(flat)


class Ordered:
    """A sample in order.

    Parameters
    ----------
    sample : ndarray
        Any shape; copied.
    step : float
        Spacing of the lattice on which the sample lies; 0 for continuous data.
    """

    def __init__(self, sample: np.ndarray, step: float = 0.0) -> None:
        self.sorted = in_order(sample, step)
        self.step = step

    def quantile(self, p: float | np.ndarray) -> np.ndarray:
        """Quantiles of the probabilities ``p``, float64."""
        if self.step:
            low, high, share = self.cells(p)
            return low + share * (high - low)
        s, n = self.sorted, self.sorted.size
        place = np.asarray(np.asarray(p, float).clip(0.0, 1.0) * n - 0.5).clip(0.0, n - 1.0)
        below = np.minimum(place.astype(np.int64), max(n - 2, 0))
        above = np.minimum(below + 1, n - 1)
        weight = place - below
        return s[below].astype(float) * (1 - weight) + s[above].astype(float) * weight

    def cells(self, p: float | np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Ends of the cells of the lattice in which the quantiles of ``p`` lie; shares below these.

        Of continuous data a cell is the quantile itself.
        """
        if not self.step:
            value = self.quantile(p)
            return value, value, np.zeros_like(value)
        place = np.asarray(p, float).clip(0.0, 1.0) * self.sorted.size
        value = self.sorted[np.minimum(place.astype(np.int64), self.sorted.size - 1)]
        below, upto = (self.sorted.searchsorted(value, side) for side in ("left", "right"))
        middle, half = value.astype(float), self.step / 2
        return middle - half, middle + half, (place - below) / (upto - below)

    def count_below(self, value: float | np.ndarray) -> np.ndarray:
        """Number of the sample below ``value``."""
        return np.searchsorted(self.sorted, self._at_least(value), "left")

    def count_above(self, value: float | np.ndarray) -> np.ndarray:
        """Number of the sample above ``value``."""
        limit = -self._at_least(-np.asarray(value))
        return self.sorted.size - np.searchsorted(self.sorted, limit, "right")

    def share_below(self, value: float | np.ndarray) -> np.ndarray:
        """Distribution function at ``value``."""
        return self.count_below(value) / self.sorted.size

    def _at_least(self, value: float | np.ndarray) -> np.ndarray:
        """The smallest number of the sample's type that is not below ``value``.

        In another type a search would first copy the whole sample.
        """
        value, kind = np.asarray(value, float), self.sorted.dtype.type
        near = value.astype(kind)
        return np.where(near < value, np.nextafter(near, kind(np.inf)), near)

    def robust_sigma(self) -> float:
        """Interquartile range / 1.349; never 0."""
        low, middle, high = self.quantile(np.array([0.25, 0.5, 0.75]))
        return _interval(high - low, middle, self.step)


class Tied(Ordered):
    """A sample of few, unevenly spaced values, such as variances of a few codes.

    The distribution function is interpolated between the middles of its steps, so that quantiles
    do not jump from value to value.
    """

    def __init__(self, sample: np.ndarray) -> None:
        self.sorted = np.sort(sample, axis=None)  # of few values faster than by their digits
        self.step = 0.0

    def quantile(self, p: float | np.ndarray) -> np.ndarray:
        """Quantiles of the probabilities ``p``, float64."""
        starts, middles = self._steps
        return np.interp(np.asarray(p, float) * self.sorted.size, middles, self.sorted[starts])

    @cached_property
    def _steps(self) -> tuple[np.ndarray, np.ndarray]:
        s = self.sorted
        starts = np.concatenate(([0], np.flatnonzero(s[1:] != s[:-1]) + 1))
        ends = np.append(starts[1:], s.size)
        return starts, (starts + ends) / 2


@dataclass(frozen=True)
class Counted:
    """A histogram of equal bins.

    Parameters
    ----------
    first : float
        Centre of the first bin.
    width : float
    counts : ndarray of int64
    """

    first: float
    width: float
    counts: np.ndarray

    @cached_property
    def cumulative(self) -> np.ndarray:
        """Counts up to the upper end of each bin, from 0 at the lower end of the first."""
        return np.concatenate(([0], np.cumsum(self.counts)))

    @property
    def total(self) -> int:
        """Number of the sample."""
        return int(self.cumulative[-1])

    @cached_property
    def _last(self) -> int:
        """The last bin that holds some."""
        return int(np.flatnonzero(self.counts > 0)[-1])

    @cached_property
    def centres(self) -> np.ndarray:
        """Centre of each bin."""
        return self.first + self.width * np.arange(self.counts.size)

    def quantile(self, p: float | np.ndarray) -> np.ndarray:
        """Quantiles of the probabilities ``p``, float64."""
        place = np.asarray(p, float).clip(0.0, 1.0) * self.total
        k = np.clip(self.cumulative.searchsorted(place, "right") - 1, 0, self._last)
        inside = (place - self.cumulative[k]) / np.maximum(self.counts[k], 1)
        return self.first + self.width * (k - 0.5 + inside.clip(0.0, 1.0))

    def share_below(self, value: float | np.ndarray) -> np.ndarray:
        """Distribution function at ``value``."""
        place = np.clip((np.asarray(value) - self.first) / self.width + 0.5, 0, self.counts.size)
        ends = np.arange(self.cumulative.size)
        return np.interp(place, ends, self.cumulative) / max(self.total, 1)

    def moments(self) -> tuple[float, float, float, float]:
        """Mean, variance, third and fourth central moment."""
        x, w = self.centres, self.counts / self.total
        mean = float(w @ x)
        d = x - mean
        return mean, float(w @ d**2), float(w @ d**3), float(w @ d**4)

    def robust_sigma(self) -> float:
        """Interquartile range / 1.349; never 0."""
        low, middle, high = self.quantile(np.array([0.25, 0.5, 0.75]))
        return _interval(high - low, middle, self.width)
