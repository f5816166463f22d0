"""Sums over pixels and their neighbours: ranks, peaks, covariances, local variances, by block."""

from __future__ import annotations

from functools import lru_cache
from typing import Self

import numpy as np

from dnanalyze.analyzers.kernels.layout import PEAK_SUMS, RANK_SUMS, TILE_SUMS
from dnanalyze.analyzers.plan import BANDS, CLIP, TAIL_CLIP, FrameView, Plan
from dnanalyze.significance import NOTICEABLE

EXCESS_SIGMAS = (4.0, 8.0, 16.0)
LAGS = ((0, 0), (1, 0), (0, 1), (1, 1), (2, 0), (0, 2))  # (dx, dy); both diagonals count as (1, 1)
SUMS = "peaks", "ranks", "lags", "inner", "tiles"
OUTLYING = NOTICEABLE  # sigmas of D: the tracks of particles lie beyond, 6e-5 of normal noise too
_BLOCK = 24  # pixels along a side of a block, at least
_TOP_SHARE = 0.01
_SAMPLE = 65536  # pixels from which the level of the top 1 % is taken


class Neighbours:
    """Block sums over the frames y and over their differences D; see `neighbour_loops`.

    Attributes are (row bands, column bands, sums) on the grid of `edges_of`, float64: ``peaks`` of
    y; ``ranks``, ``lags``, ``inner`` and ``tiles`` of D. ``inner`` are lags without outlying pixels
    and the number of the others, where errors are wanted. ``each`` holds, by the same names, the
    sums over the field of each y and each D.
    """

    def __init__(self, plan: Plan) -> None:
        grid = grid_of(plan)
        self.plan = plan
        self.frames = 0
        self.differences = 0
        self.peaks = np.zeros((*grid, PEAK_SUMS))
        self.ranks = np.zeros((*grid, RANK_SUMS))
        self.lags = np.zeros((*grid, len(LAGS)))
        self.inner = np.zeros((*grid, len(LAGS) + 1))
        self.tiles = np.zeros((*grid, TILE_SUMS))
        self.each: dict[str, list[np.ndarray]] = {name: [] for name in SUMS}

    def add(self, view: FrameView) -> None:
        """Take in the next frame, and its difference to the one before."""
        from dnanalyze.analyzers.kernels import neighbour_loops

        plan = self.plan
        leads = np.array(EXCESS_SIGMAS) * plan.difference_sigma
        top, share = top_level(view.frame)
        peaks = np.zeros_like(self.peaks)
        rows, columns = edges_of(plan)
        neighbour_loops.peak_sums(
            view.frame, top, share, leads, _widths(plan, leads), rows, columns, peaks
        )
        self._take("peaks", peaks)
        self.frames += 1
        if view.difference is not None:
            self._add_difference(view.difference)

    def merge(self, later: Self, seam: FrameView) -> None:
        """Take in the frames that follow mine."""
        assert seam.difference is not None
        self._add_difference(seam.difference)
        self.frames += later.frames
        self.differences += later.differences
        for name in SUMS:
            mine: np.ndarray = getattr(self, name)
            mine += getattr(later, name)
            self.each[name] += later.each[name]

    def _add_difference(self, difference: np.ndarray) -> None:
        from dnanalyze.analyzers.kernels import neighbour_loops

        plan = self.plan
        self.differences += 1
        self._take("ranks", rank_shares(plan, difference))
        self._take("lags", lag_products(plan, difference, CLIP * plan.difference_sigma))
        if plan.errors:
            inner = np.zeros_like(self.inner)
            reach = OUTLYING * plan.difference_sigma
            by_row, by_column = neighbour_loops.line_means(difference, reach)
            neighbour_loops.inner_sums(difference, reach, by_row, by_column, *edges_of(plan), inner)
            self._take("inner", inner)
        tiles = np.zeros_like(self.tiles)
        reach = TAIL_CLIP * plan.difference_sigma
        bands = _bands(plan.shape[0]), _bands(plan.shape[1])
        neighbour_loops.tile_sums(difference, reach, *bands, tiles)
        self._take("tiles", tiles)

    def _take(self, name: str, sums: np.ndarray) -> None:
        mine: np.ndarray = getattr(self, name)
        mine += sums
        self.each[name].append(sums.sum(axis=(0, 1)))


def _widths(plan: Plan, leads: np.ndarray) -> np.ndarray:
    """Width over which a lead begins to count, DN.

    A code stands for all within half a DN of it. Were it counted whole or not at all, a lead of
    exactly 2 would depend on the last digit of a sigma of .5.
    """
    return np.minimum(1.0, leads) if plan.integer else 1e-6 * leads


def edges_of(plan: Plan) -> tuple[np.ndarray, np.ndarray]:
    """First line of each band, and the end, of rows and of columns, int64.

    The bands are wider than the plan's on small frames: neighbouring ranks depend on one another.
    """
    return _edges(plan.shape[0]), _edges(plan.shape[1])


@lru_cache(maxsize=64)
def _edges(size: int) -> np.ndarray:
    bands = max(1, min(BANDS, size // _BLOCK))
    edges = np.arange(bands + 1, dtype=np.int64) * size // bands
    edges.setflags(write=False)
    return edges


@lru_cache(maxsize=64)
def _bands(size: int) -> np.ndarray:
    """Number of the band in which each line lies, int64."""
    edges = _edges(size)
    bands = np.repeat(np.arange(edges.size - 1), np.diff(edges))
    bands.setflags(write=False)
    return bands


def grid_of(plan: Plan) -> tuple[int, int]:
    """Row bands and column bands of `edges_of`."""
    rows, columns = edges_of(plan)
    return rows.size - 1, columns.size - 1


def lag_products(plan: Plan, image: np.ndarray, reach: float) -> np.ndarray:
    """Block sums of the products at `LAGS`; row and column means are removed first."""
    from dnanalyze.analyzers.kernels import neighbour_loops

    out = np.zeros((*grid_of(plan), len(LAGS)))
    by_row, by_column = neighbour_loops.line_means(image, reach)
    neighbour_loops.lag_sums(image, reach, by_row, by_column, *edges_of(plan), out)
    return out


def rank_shares(plan: Plan, image: np.ndarray) -> np.ndarray:
    """Block sums of the shares in being highest and lowest of 9, of one image."""
    from dnanalyze.analyzers.kernels import neighbour_loops

    out = np.zeros((*grid_of(plan), RANK_SUMS))
    neighbour_loops.rank_sums(image, *edges_of(plan), out)
    return out


def top_level(frame: np.ndarray) -> tuple[float, float]:
    """Where the top 1 % of a frame begin, from an even sample of its pixels.

    Parameters
    ----------
    frame : ndarray
        (rows, columns), DN, float32.

    Returns
    -------
    level : float
        DN.
    share : float
        Share of the pixels at exactly this level that are among the top 1 %.
    """
    from dnanalyze.analyzers.kernels.sorting import order_statistic

    step = max(1, int(np.sqrt(frame.size / _SAMPLE)))
    step += 1 - step % 2  # an odd step meets all phases of a two-column or colour pattern
    sample = np.ravel(frame[::step, ::step])
    place = min(sample.size - 1, int((1 - _TOP_SHARE) * sample.size))
    level, below, alike = order_statistic(sample, place)
    if not below:  # nearly all lie at one code: those there are no peaks, nor tied
        return float(level), 0.0
    above = sample.size - below - alike
    return float(level), min(1.0, max(0.0, (_TOP_SHARE * sample.size - above) / alike))
