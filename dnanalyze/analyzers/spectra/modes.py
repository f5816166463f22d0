"""Geometry of a frame's Fourier modes: usable size, radial bins, bands; and power by mode.

Powers are normalised so that white noise of variance s^2 has power s^2 (DN^2) in every mode.
u is the horizontal, v the vertical frequency, cycles/pixel; the half plane u >= 0 is stored,
(v, u).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy.fft

RADIAL_BANDS = (0.0, 0.01, 0.02, 0.04, 0.08, 0.16, 0.25, 0.35, 0.5, 0.71)
STRUCTURE_BANDS = (0.0, 0.02, 0.1, 0.3, 0.5)  # on the axes
PROFILE_BANDS = (0.0, 0.03, 0.1, 0.3, 0.5)  # along one direction, averaged over the other
FIRST_MODES = 3  # lowest frequencies, kept apart in the profiles
SLOPE_BANDS = {"low": (0.005, 0.05), "mid": (0.05, 0.2), "high": (0.2, 0.5)}
HIGH_BAND = (0.45, 0.71)  # of the high-to-mid ratio
MID_BAND = (0.03, 0.12)
SMALLEST_SIDE = 8  # pixels; below this a spectrum says nothing
_MOST_LOST = 0.03  # share of the lines that may be given up for a fast FFT
_BAND = 1 << 16  # modes that are transformed along the rows together, in the cache
_RADIAL_STEP = 1.08  # ratio of successive edges of the fine radial bins


def good_size(size: int) -> int:
    """Largest even number up to ``size`` with a fast FFT: no prime factor above 11.

    Where that would lose more than 3 % of the lines, the largest even number.
    """
    even = size - size % 2
    for good in range(even, int(size * (1 - _MOST_LOST)), -2):
        if scipy.fft.next_fast_len(good, real=False) == good:
            return good
    return even


@dataclass(frozen=True, eq=False)
class Modes:
    """The modes of a frame of one shape, each object unlike any other.

    Parameters
    ----------
    shape : tuple of int
        (rows, columns) after the crop to fast sizes.
    edges : ndarray
        Fine radial bins, cycles/pixel; every band edge is among them.
    index : ndarray of uint8
        Fine radial bin of each mode, (rows, columns // 2 + 1); 255 on the axes u = 0 and v = 0.
    count : ndarray
        Independent off-axis modes of each bin; one and its conjugate count once.
    rho : ndarray
        Mean radial frequency of each bin, cycles/pixel; NaN in an empty bin.
    axis_bin : tuple of ndarray
        Fine radial bin of the modes (u > 0, v = 0), and of (u = 0, v > 0).
    """

    shape: tuple[int, int]
    edges: np.ndarray
    index: np.ndarray
    count: np.ndarray
    rho: np.ndarray
    axis_bin: tuple[np.ndarray, np.ndarray]

    @property
    def pixels(self) -> int:
        """Pixels of the cropped frame."""
        return self.shape[0] * self.shape[1]

    @cached_property
    def u(self) -> np.ndarray:
        """Horizontal frequencies above 0, cycles/pixel."""
        return np.arange(1, self.shape[1] // 2 + 1) / self.shape[1]

    @cached_property
    def v(self) -> np.ndarray:
        """Vertical frequencies above 0, cycles/pixel."""
        return np.arange(1, self.shape[0] // 2 + 1) / self.shape[0]

    @cached_property
    def seen(self) -> np.ndarray:
        """Fine bins that hold a mode off the axes."""
        return self.count > 0

    @cached_property
    def full_count(self) -> np.ndarray:
        """As ``count`` with the modes of the two axes."""
        size = self.count.size
        return sum((np.bincount(bins, minlength=size) for bins in self.axis_bin), self.count)

    def bins(self, low: float, high: float) -> slice:
        """The fine bins from ``low`` to ``high``, both among the edges."""
        first, last = (bisect_left(self.edge_list, f - 1e-9) for f in (low, high))
        return slice(first, last)

    @cached_property
    def edge_list(self) -> list[float]:
        """``edges`` as a list, which is faster to search for one number."""
        return [float(e) for e in self.edges]


@lru_cache(maxsize=16)
def modes_of(shape: tuple[int, int]) -> Modes:
    """Modes of frames of this shape; both sides must have 8 pixels or more."""
    rows, columns = good_size(shape[0]), good_size(shape[1])
    v = np.abs(np.fft.fftfreq(rows)).astype(np.float32)[:, None]
    u = np.fft.rfftfreq(columns).astype(np.float32)[None, :]
    rho = np.sqrt(u * u + v * v)
    edges = _fine_edges(max(rows, columns))
    index = (np.searchsorted(edges, rho.ravel() + 1e-7, side="right") - 1).astype(np.uint8)
    index = index.reshape(rho.shape)
    weight = np.ones_like(rho)
    weight[:, -1] = 0.5  # both v and -v stand in this column
    axis_bin = (index[0, 1:].copy(), index[1 : rows // 2 + 1, 0].copy())
    index[0, :] = 255
    index[:, 0] = 255
    size = edges.size - 1
    count = np.bincount(index.ravel(), weight.ravel(), minlength=256)[:size]
    total = np.bincount(index.ravel(), (weight * rho).ravel(), minlength=256)[:size]
    mean = np.divide(total, count, out=np.full(size, np.nan), where=count > 0)
    for array in (index, edges, count, mean, *axis_bin):
        array.setflags(write=False)
    return Modes((rows, columns), edges, index, count, mean, axis_bin)


def _fine_edges(side: int) -> np.ndarray:
    """Edges in steps of 8 %, but no finer than the modes; the edges of all bands are among them."""
    fixed = {*RADIAL_BANDS, *HIGH_BAND, *MID_BAND, *(e for b in SLOPE_BANDS.values() for e in b)}
    edges = [0.0]
    while edges[-1] < RADIAL_BANDS[-1]:
        edges.append(max(edges[-1] + 1.0 / side, edges[-1] * _RADIAL_STEP))
    kept = [
        e for e in edges if min(abs(e - f) for f in fixed) > 0.4 / side and e < RADIAL_BANDS[-1]
    ]
    return np.array(sorted(fixed | set(kept)))


def transform_of(rows_of: Callable[[slice], np.ndarray], out: np.ndarray) -> np.ndarray:
    """2-D Fourier transform of a real image that is given some rows at a time.

    Parameters
    ----------
    rows_of : callable
        Gives these rows of the image, float32, (some, columns); it sees all rows once, in order.
    out : ndarray of complex64
        (rows, columns // 2 + 1), columns even; room for the result.

    Returns
    -------
    ndarray of complex64
        As ``out``, in its memory where that can be.
    """
    step = max(1, _BAND // out.shape[1])
    for top in range(0, out.shape[0], step):
        rows = slice(top, min(top + step, out.shape[0]))
        out[rows] = scipy.fft.rfft(rows_of(rows))
    return np.asarray(scipy.fft.fft(out, axis=0, overwrite_x=True))


def power_of(image: np.ndarray, shape: tuple[int, int] | None = None) -> np.ndarray:
    """Power of each mode of an image, its mean removed.

    Parameters
    ----------
    image : ndarray
        (rows, columns), DN.
    shape : tuple of int, optional
        What the image is cropped to at the far edges; a fast size by default.

    Returns
    -------
    ndarray
        (rows, columns // 2 + 1), DN^2, of the cropped shape.
    """
    from dnanalyze.analyzers.kernels import mode_loops

    rows, columns = shape or (good_size(image.shape[0]), good_size(image.shape[1]))
    power = np.zeros((rows, columns // 2 + 1))
    cropped = np.asarray(image[:rows, :columns], np.float32)
    transform = transform_of(cropped.__getitem__, np.empty(power.shape, np.complex64))
    mode_loops.add_power(power, transform, 1.0 / (rows * columns))
    return power


@dataclass(frozen=True)
class ReducedPower:
    """A 2-D power spectrum reduced to what the statistics need.

    Parameters
    ----------
    modes : Modes
    radial, radial_square : ndarray
        Sum over the off-axis modes of each fine radial bin, each independent mode once, of the
        powers, DN^2, and of their squares.
    columns : ndarray
        Power of (u > 0, v = 0): what whole columns share, DN^2.
    rows : ndarray
        Power of (u = 0, v > 0): what whole rows share, DN^2.
    horizontal, horizontal_square : ndarray
        Mean over v != 0 at each u > 0 of the powers, DN^2, and of their squares.
    vertical, vertical_square : ndarray
        Mean over u != 0 at each v > 0.
    """

    modes: Modes
    radial: np.ndarray
    columns: np.ndarray
    rows: np.ndarray
    horizontal: np.ndarray
    vertical: np.ndarray
    radial_square: np.ndarray
    horizontal_square: np.ndarray
    vertical_square: np.ndarray

    def radial_mean(self) -> np.ndarray:
        """Mean off-axis power of each fine bin, DN^2; NaN where a bin is empty."""
        n, seen = self.modes.count, self.modes.seen
        return np.divide(self.radial, n, out=np.full(n.size, np.nan), where=seen)

    def radial_mean_full(self) -> np.ndarray:
        """As ``radial_mean`` with the modes of the two axes."""
        total, n = self.radial.copy(), self.modes.full_count
        for where, power in zip(self.modes.axis_bin, (self.columns, self.rows), strict=True):
            total += np.bincount(where, power, minlength=n.size)
        return np.divide(total, n, out=np.full(n.size, np.nan), where=n > 0)


def reduce_power(power: np.ndarray, modes: Modes) -> ReducedPower:
    """Reduce a 2-D power spectrum, (rows, columns // 2 + 1), DN^2."""
    from dnanalyze.analyzers.kernels import mode_loops

    rows, columns = modes.shape
    radial, by_u, by_v = mode_loops.reduce(power, modes.index)
    half = rows // 2
    vertical = by_v[:, 1 : half + 1].copy()
    vertical[:, :-1] += by_v[:, :half:-1]
    n = np.full(half, columns - 1.0)
    n[-1] /= 2
    size = modes.edges.size - 1
    return ReducedPower(
        modes,
        radial[0, :size],
        power[0, 1:].copy(),  # a view would keep the whole power
        power[1 : half + 1, 0].copy(),
        by_u[0, 1:] / (rows - 1),
        vertical[0] / n,
        radial[1, :size],
        by_u[1, 1:] / (rows - 1),
        vertical[1] / n,
    )


def frame_repeats(total: float, temporal: float, frames: int) -> float:
    """Independent spectra that the mean over ``frames`` is worth, which share their DSNU.

    A mode of fixed power p and temporal power t has a mean of variance p^2 + (2 p t + t^2) / K.
    """
    fixed = max(total - temporal, 0.0)
    variance = fixed**2 + (2 * fixed * temporal + temporal**2) / frames
    return (fixed + temporal) ** 2 / variance if variance > 0 else 1.0
