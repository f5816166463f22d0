"""What is fixed before the streaming pass begins, and what the accumulators see of each frame."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

CLIP = 6.0  # robust sigmas at which winsorised data are cut
TAIL_CLIP = 8.0  # temporal sigmas at which differences are cut where their tails count
LOOKS = 64  # rows and columns that tell the level of a frame: to 1.25 / 64 of its sigma
BANDS = 32  # row bands and column bands of the block grid, where the frame is large enough
SMALLEST_BANDS = (4, 8)  # rows, columns
PART = 1 << 16  # pixels of a map that are worked on together


@dataclass(frozen=True)
class Plan:
    """Scales of a setting, from its first frames, so that one pass is enough.

    Parameters
    ----------
    shape : tuple of int
        (rows, columns) of the frames.
    centre : float
        Median of the first frame, DN.
    sigma : float
        Robust sigma (interquartile range / 1.349) of the first frame, DN; never 0.
    difference_sigma : float
        Robust sigma of the first difference (y_1 - y_0) / sqrt 2, DN; never 0. ``sigma`` where
        there is one frame.
    low, high : float
        Smallest and largest value of the first frame, DN.
    integer : bool
        All pixels of the first frame are whole numbers: the data are codes of a converter.
    errors : bool
        Standard errors are wanted; without them (simulated frames in a fit) they are left at their
        lower bounds, and what is given for information alone may be left out.
    families : tuple of str
        Families that are wanted, by name; empty for all.
    """

    shape: tuple[int, int]
    centre: float
    sigma: float
    difference_sigma: float
    low: float
    high: float
    integer: bool
    errors: bool = True
    families: tuple[str, ...] = ()

    def wants(self, *families: str) -> bool:
        """Whether one of these families is wanted."""
        return not self.families or not set(self.families).isdisjoint(families)

    @property
    def pixels(self) -> int:
        """Pixels of a frame."""
        return self.shape[0] * self.shape[1]

    @cached_property
    def row_edges(self) -> np.ndarray:
        """First row of each row band of the block grid, and the end; int64."""
        return _edges(self.shape[0], SMALLEST_BANDS[0])

    @cached_property
    def column_edges(self) -> np.ndarray:
        """First column of each column band of the block grid, and the end; int64."""
        return _edges(self.shape[1], SMALLEST_BANDS[1])

    @cached_property
    def row_parts(self) -> list[slice]:
        """Row bands one after another that are small enough together to stay in the cache."""
        bands = self.row_edges.size - 1
        together = max(1, PART * bands // self.pixels)
        return [slice(first, min(first + together, bands)) for first in range(0, bands, together)]

    def rows_of(self, bands: slice) -> slice:
        """The rows of some row bands."""
        return slice(int(self.row_edges[bands.start]), int(self.row_edges[bands.stop]))

    def sample(self, image: np.ndarray) -> np.ndarray:
        """At least `LOOKS` of its rows and columns, where it has as many, evenly over the field."""
        rows, columns = (max(1, size // LOOKS) for size in self.shape)
        return image[::rows, ::columns]

    @cached_property
    def block_pixels(self) -> np.ndarray:
        """Pixels of each block, (row bands, column bands)."""
        return np.outer(np.diff(self.row_edges), np.diff(self.column_edges)).astype(float)


def _edges(size: int, smallest: int) -> np.ndarray:
    bands = max(1, min(BANDS, size // smallest))
    return np.arange(bands + 1, dtype=np.int64) * size // bands


@dataclass(frozen=True)
class FrameView:
    """One frame as the accumulators see it; the arrays are shared and must not be written to.

    Parameters
    ----------
    number : int
        Of the frame in its setting, from 0.
    frame : ndarray of float32
        (rows, columns), DN.
    difference : ndarray of float32 or None
        (this frame - the one before) / sqrt 2, DN; None for the first.
    plan : Plan
    shift : float
        By how much the level of this frame has moved from the plan's centre, DN; 0 where that is
        less than ``plan.sigma``. Cuts and limits move along.
    """

    number: int
    frame: np.ndarray
    difference: np.ndarray | None
    plan: Plan
    shift: float = 0.0
