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
    ends : ndarray
        Probabilities at the ends of the groups, from 0 to 1.
    counts, sums : ndarray
        Below each of the ends, (row bands, column bands, ends).
    tied, tied_sums : ndarray
        Pixels of the cell in which each end lies, and what they sum up to, (ends,).
    """

    ends: np.ndarray
    counts: np.ndarray
    sums: np.ndarray
    tied: np.ndarray
    tied_sums: np.ndarray

    def pixels(self, group: int) -> float:
        """Pixels of a group."""
        return float(_between(self.counts, group).sum())

    def mean(self, group: int) -> float:
        """Mean over the pixels of a group."""
        return float(_between(self.sums, group).sum()) / self.pixels(group)

    def relative_error(self, group: int) -> float:
        """Standard error of the mean over the mean.

        By chance the quantiles of a sample lie elsewhere too: what that moves from a group to the
        next is worth the mean of the cell there.
        """
        mean, sums = self.mean(group), _between(self.sums, group)
        worth = (self.tied_sums - mean * self.tied) / np.maximum(self.tied, 1.0)
        # pixels of the block below each end, more than its share of the field's
        beside = self.counts - self.ends * self.counts[..., -1:]
        low, high = np.moveaxis((worth * beside)[..., group : group + 2], 2, 0)
        residual = sums - mean * _between(self.counts, group) - (high - low)
        return math.sqrt(float(clustered_variance(residual / sums.sum())))


def _between(below: np.ndarray, group: int) -> np.ndarray:
    """Of each block, from what lies below the ends of the groups."""
    return np.asarray(below[..., group + 1] - below[..., group])


def groups(
    plan: Plan, key: np.ndarray, ordered: Ordered, weight: np.ndarray, cuts: np.ndarray
) -> Groups:
    """Sums of ``weight`` over the pixels between quantiles of ``key``.

    Groups share the pixels of the cell that a cut lies in. On little noise most pixels have one
    code: all of them in one group, or none, would be chance.

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
    ends = np.concatenate([low, high])

    def at_ends(below: np.ndarray, whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        within = below[..., cuts.size :] - below[..., : cuts.size]
        out, tied = np.zeros((*whole.shape, cuts.size + 2)), np.zeros(cuts.size + 2)
        out[..., 1:-1] = below[..., : cuts.size] + share * within
        out[..., -1] = whole
        tied[1:-1] = within.sum(axis=(0, 1))
        return out, tied

    counts, tied = at_ends(counts_below(plan, key, ends), plan.block_pixels)
    below = sums_below(plan, key, weight, ends)
    sums, tied_sums = at_ends(below[..., :-1], below[..., -1])
    return Groups(np.concatenate([[0.0], cuts, [1.0]]), counts, sums, tied, tied_sums)
