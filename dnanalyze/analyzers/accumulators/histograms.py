"""Histograms over all frames of a setting: of the values and of the temporal differences."""

from __future__ import annotations

import math
from typing import Self

import numpy as np

from dnanalyze.analyzers.estimators.quantiles import Counted
from dnanalyze.analyzers.plan import FrameView, Plan

CODES = 1 << 16
WIDE = 1 << 18  # where codes leave the range of 16 bits
DIFFERENCES = 1 << 13
FINE = 64  # bins a robust sigma, for continuous data


class Histograms:
    """Counts of values and of differences, DN.

    Codes are counted one by one. Continuous values have 64 bins a robust sigma. Differences of
    codes have bins of an odd number of steps 1/sqrt 2, at most about 1/64 of their robust sigma
    or one step.
    """

    def __init__(self, plan: Plan) -> None:
        sixteen = plan.integer and plan.low >= 0 and plan.high < CODES
        bins = WIDE if plan.integer and not sixteen else CODES
        width = 1.0 if plan.integer else plan.sigma / FINE
        first = 0.0 if sixteen else round(plan.centre / width) * width - width * bins / 8
        step = plan.difference_sigma / FINE
        if plan.integer:
            step = math.sqrt(0.5) * (2 * int(step * math.sqrt(0.5)) + 1)
        self._values = (first, width, np.zeros((4, bins), np.int64))
        low = -step * (DIFFERENCES // 2)
        self._differences = (low, step, np.zeros((4, DIFFERENCES), np.int64))

    def add(self, view: FrameView) -> None:
        """Count a frame and its difference."""
        from dnanalyze.analyzers.kernels import pixel_loops

        pixel_loops.tally(view.frame.ravel(), *self._values)
        self._add_difference(view)

    def merge(self, later: Self, seam: FrameView) -> None:
        """Take in the frames that follow mine."""
        self._values[2][:] += later._values[2]
        self._differences[2][:] += later._differences[2]
        self._add_difference(seam)

    def _add_difference(self, view: FrameView) -> None:
        from dnanalyze.analyzers.kernels import pixel_loops

        if view.difference is not None:
            pixel_loops.tally(view.difference.ravel(), *self._differences)

    def values(self) -> Counted:
        """All values, cut to the bins that hold some."""
        return _trimmed(*self._values)

    def differences(self) -> Counted:
        """All differences, cut to the bins that hold some."""
        return _trimmed(*self._differences)


def _trimmed(first: float, width: float, counts: np.ndarray) -> Counted:
    total = counts.sum(axis=0)
    held = np.flatnonzero(total > 0)  # of booleans, eight times as fast
    if not held.size:
        return Counted(first, width, total[:1])
    low, high = int(held[0]), int(held[-1])
    return Counted(first + width * low, width, total[low : high + 1].copy())
