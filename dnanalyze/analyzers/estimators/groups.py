"""Means of one map over groups of the pixels, by the quantile of another."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.estimators.quantiles import Ordered
from dnanalyze.analyzers.estimators.uncertainty import clustered_variance, counts_below, sums_below
from dnanalyze.analyzers.plan import Plan


@dataclass(frozen=True)
class Groups:
    """Pixels of each block and what they sum up to, by group.

    Parameters
    ----------
    counts, sums : ndarray
        (row bands, column bands, groups).
    beside : ndarray
        Pixels of the block below each end of a group, more than its share of the field's.
    tied, tied_sums : ndarray
        Pixels of the cell in which each end lies, and what they sum up to.
    """

    counts: np.ndarray
    sums: np.ndarray
    beside: np.ndarray
    tied: np.ndarray
    tied_sums: np.ndarray

    def pixels(self, group: int) -> float:
        """Pixels of a group."""
        return float(self.counts[..., group].sum())

    def mean(self, group: int) -> float:
        """Mean over the pixels of a group."""
        return float(self.sums[..., group].sum()) / self.pixels(group)

    def relative_error(self, group: int) -> float:
        """Standard error of the mean over the mean.

        By luck the quantiles of a sample lie elsewhere too: what that moves from a group to the
        next is worth the mean of the cell there.
        """
        mean = self.mean(group)
        worth = (self.tied_sums - mean * self.tied) / np.maximum(self.tied, 1.0)
        low, high = np.moveaxis((worth * self.beside)[..., group : group + 2], 2, 0)
        residual = self.sums[..., group] - mean * self.counts[..., group] - (high - low)
        return math.sqrt(float(clustered_variance(residual / self.sums[..., group].sum())))


def groups(
    plan: Plan, key: np.ndarray, ordered: Ordered, weight: np.ndarray, cuts: np.ndarray
) -> Groups:
    """Sums of ``weight`` over the pixels between quantiles of ``key``.

    Groups share the pixels of the cell that a cut lies in. On little noise most pixels have one
    code: all of them in one group, or none, would be luck.

    Parameters
    ----------
    plan : Plan
    key, weight : ndarray
        (rows, columns), float32.
    ordered : Ordered
        The pixels of ``key`` in order.
    cuts : ndarray
        Probabilities between 0 and 1, one less than there are groups.
    """
    low, high, share = ordered.cells(cuts)
    ends, blocks = np.concatenate([low, high]), plan.block_pixels

    def of_groups(below: np.ndarray, whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        under, upto = np.split(below, 2, axis=2)
        between = np.dstack([under + share * (upto - under), whole])
        return between, np.pad((upto - under).sum(axis=(0, 1)), 1)

    counts, tied = of_groups(counts_below(plan, key, ends), blocks)
    below = sums_below(plan, key, weight, ends)
    sums, tied_sums = of_groups(below[..., :-1], below[..., -1])
    beside = np.pad(counts[..., :-1] - cuts * blocks[..., None], ((0, 0), (0, 0), (1, 1)))
    counts, sums = (np.diff(each, axis=2, prepend=0.0) for each in (counts, sums))
    return Groups(counts, sums, beside, tied, tied_sums)
