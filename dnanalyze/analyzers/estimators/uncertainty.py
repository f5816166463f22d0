"""Standard errors from the scatter of neighbouring blocks, clustered by row and column bands.

Pixels share the offsets of their row and of their column, so square blocks alone would count
shared errors as independent. The two-way clustered variance (Cameron, Gelbach and Miller, J. Bus.
Econ. Stat. 29, 238 (2011)) is that of row bands plus that of column bands less that of their
crossings.

Each of the three is taken from differences of neighbours (von Neumann, Ann. Math. Stat. 12, 367
(1941)), which a smooth surface and profiles of rows and columns leave alone: glow, gradients and
shading are the same in the next sensor of the design and are no scatter.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dnanalyze.analyzers.estimators.quantiles import Counted, Ordered
from dnanalyze.analyzers.plan import Plan

_NONE = np.empty(0, np.float32)  # thresholds


def counts_below(plan: Plan, key: np.ndarray, thresholds: np.ndarray) -> np.ndarray:
    """Pixels of ``key`` below each threshold, (row bands, column bands, thresholds)."""
    from dnanalyze.analyzers.kernels import pixel_loops

    out = np.zeros((plan.row_edges.size - 1, plan.column_edges.size - 1, len(thresholds)))
    limits = np.asarray(thresholds, np.float32)
    pixel_loops.count_below(key, limits, plan.row_edges, plan.column_edges, out)
    return out


def sums_below(
    plan: Plan, key: np.ndarray, weight: np.ndarray, thresholds: np.ndarray = _NONE
) -> np.ndarray:
    """Sums of ``weight`` where ``key`` is below each threshold, and over all pixels of the block.

    Returns
    -------
    ndarray
        (row bands, column bands, thresholds + 1).
    """
    from dnanalyze.analyzers.kernels import pixel_loops

    limits = np.asarray(thresholds, np.float32)
    out = np.zeros((plan.row_edges.size - 1, plan.column_edges.size - 1, limits.size + 1))
    pixel_loops.sum_below(key, weight, limits, plan.row_edges, plan.column_edges, out)
    return out


def block_sums(plan: Plan, of: Callable[..., np.ndarray], *maps: np.ndarray) -> np.ndarray:
    """Sums over each block of a function of maps, (row bands, column bands).

    ``of`` is called with the same rows of each map, (rows, columns), and gives float32 of that
    shape. It sees some row bands at a time: what it works out stays in the cache.
    """
    from dnanalyze.analyzers.kernels import pixel_loops

    out = np.zeros((plan.row_edges.size - 1, plan.column_edges.size - 1, 1))
    for bands in plan.row_parts:
        rows = plan.rows_of(bands)
        values = of(*(each[rows] for each in maps))
        edges = plan.row_edges[bands.start : bands.stop + 1] - rows.start
        pixel_loops.sum_below(values, values, _NONE, edges, plan.column_edges, out[bands])
    return out[..., 0]


def map_sums(plan: Plan, each: np.ndarray) -> np.ndarray:
    """Sums over each block of a map, (row bands, column bands)."""
    return sums_below(plan, each, each)[..., 0]


def mean_residuals(plan: Plan, sums: np.ndarray) -> np.ndarray:
    """What each block adds to the error of the mean over all pixels, from the block sums."""
    return (sums - plan.block_pixels * (sums.sum() / plan.pixels)) / plan.pixels


def share_residuals(plan: Plan, below: np.ndarray) -> np.ndarray:
    """What each block adds to the error of the shares ``counts_below`` / pixels; same shape."""
    share = below.sum(axis=(0, 1)) / plan.pixels
    return (below - plan.block_pixels[..., None] * share) / plan.pixels


def _scatter(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Covariance of two sums over blocks: that of single blocks, and what lines add to it.

    Also the standard deviation that the first has by chance where the two are independent.
    """
    from dnanalyze.analyzers.kernels import pixel_loops

    rows, columns = a.shape[:2]
    flat = (rows, columns, a.size // (rows * columns))
    out = np.zeros((3, flat[2]))
    pixel_loops.block_covariance(a.reshape(flat), b.reshape(flat), out)
    each, lines, chance = out.reshape(3, *a.shape[2:])
    return each, lines, np.sqrt(chance)


def _chance_of_lines(rows: int, columns: int) -> float:
    """Standard deviation, over the variance of blocks, of what lines add where they add nothing.

    Less than this is not told from none. Neighbouring fourth differences share bands: the sum of
    their squared correlations is 1 + 2 (56^2 + 28^2 + 8^2 + 1) / 70^2.
    """
    if min(rows, columns) < 5:
        return 0.0
    overlap = 1.0 + 2.0 * (56**2 + 28**2 + 8**2 + 1) / 70**2
    return math.sqrt(2.0 * overlap * (1.0 / (rows - 4) + 1.0 / (columns - 4)))


def clustered_variance(residuals: np.ndarray) -> np.ndarray:
    """Variance of the sum of ``residuals``, (row bands, column bands, ...), over the blocks."""
    return repeated_variance([residuals], 1.0)


def repeated_variance(sides: list[np.ndarray], repeats: float) -> np.ndarray:
    """Variance of a sum over blocks, averaged over frames.

    Parameters
    ----------
    sides : list of ndarray
        Block residuals, (row bands, column bands, ...), of zero sum over the blocks: of one frame,
        or of two frames that share the pixels but not the temporal noise. Their covariance is the
        part that further frames do not reduce.
    repeats : float
        Independent frames behind the estimate.
    """
    singles = [_scatter(side, side) for side in sides]
    blocks = sum(s[0] for s in singles) / len(sides)
    by_chance = _chance_of_lines(*sides[0].shape[:2]) * blocks
    bands = np.maximum(sum(s[1] for s in singles) / len(sides) - by_chance, 0.0)
    if repeats > 1 and len(sides) > 1:
        each, lines, chance = _scatter(sides[0], sides[1])
        common = np.clip(each - chance, 0.0, blocks)
        share = common / np.maximum(blocks, 1e-300)
        seen = bands > 0.5 * blocks  # else what lines add is itself chance
        common_lines = np.where(seen, np.clip(lines, 0.0, bands), share * bands)
        common = common + common_lines
        return np.asarray(common + (blocks + bands - common) / repeats)
    return np.asarray(blocks + bands)


def mean_error(plan: Plan, *sums: np.ndarray, repeats: float = 1.0) -> float:
    """Standard error of the mean over all pixels of a map, from its `block_sums`.

    With those of two maps (of two frames) and ``repeats``, that of the mean over so many frames.
    """
    if not plan.errors:
        return 0.0
    sides = [mean_residuals(plan, each) for each in sums]
    return float(np.sqrt(repeated_variance(sides, repeats)))


@dataclass(frozen=True)
class QuantileErrors:
    """Joint sampling errors of quantiles of one map, or of several maps of one law.

    Parameters
    ----------
    plan : Plan
    maps : tuple of ndarray of float32
        One map; or two frames (or differences) that share the pixels but not the temporal noise,
        whose covariance tells how much further frames help.
    law : Ordered or Counted
        From which the quantiles were taken.
    probabilities : ndarray
    repeats : float
        Independent frames behind ``law``; 1 for a single map.
    """

    plan: Plan
    maps: tuple[np.ndarray, ...]
    law: Ordered | Counted
    probabilities: np.ndarray
    repeats: float = 1.0

    @cached_property
    def values(self) -> np.ndarray:
        """The quantiles, DN."""
        return self.law.quantile(self.probabilities)

    @cached_property
    def _shares(self) -> list[np.ndarray]:
        """Residual share below each quantile, per block: (row bands, column bands, quantiles)."""
        return [
            share_residuals(self.plan, counts_below(self.plan, each, self.values))
            for each in self.maps
        ]

    @cached_property
    def _slopes(self) -> np.ndarray:
        """DN per unit of probability at each quantile (Woodruff's interval)."""
        p, n = self.probabilities, self.plan.pixels
        s = np.sqrt(self._variance(np.eye(p.size)))
        s = np.maximum(s, np.sqrt(np.maximum(p * (1 - p), 1 / n) / (n * self.repeats)))
        edge = 0.5 / n
        low, high = np.clip(p - s, edge, 1 - edge), np.clip(p + s, edge, 1 - edge)
        return (self.law.quantile(high) - self.law.quantile(low)) / np.maximum(high - low, edge)

    def _variance(self, weights: np.ndarray) -> np.ndarray:
        """Variance of combinations of shares; ``weights`` is (quantiles, combinations)."""
        return repeated_variance([share @ weights for share in self._shares], self.repeats)

    def of(self, combinations: np.ndarray) -> np.ndarray:
        """Standard errors of linear combinations of the quantiles, DN.

        Parameters
        ----------
        combinations : ndarray
            (quantiles,) or (quantiles, combinations).
        """
        combinations = np.asarray(combinations, float)
        if not self.plan.errors:
            return np.zeros(combinations.shape[1:])
        columns = combinations.reshape(self.probabilities.size, -1)
        variance = self._variance(columns * self._slopes[:, None])
        return np.sqrt(variance).reshape(combinations.shape[1:])

    def over_mean(self, sample: np.ndarray) -> np.ndarray:
        """Relative standard errors of quantile / mean of a single map."""
        if not self.plan.errors:
            return np.zeros(self.probabilities.size)
        mean = float(sample.mean(dtype=np.float64))
        residual = mean_residuals(self.plan, map_sums(self.plan, sample))[..., None] / mean
        scale = self._slopes / np.maximum(np.abs(self.values), 1e-30)
        return np.sqrt(clustered_variance(self._shares[0] * scale + residual))
