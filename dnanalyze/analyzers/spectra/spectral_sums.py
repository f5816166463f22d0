"""Sums of the frames' Fourier powers: the spectra of single frames and of the temporal noise."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Self

import numpy as np

from dnanalyze.analyzers.plan import CLIP, FrameView, Plan
from dnanalyze.analyzers.spectra.modes import SMALLEST_SIDE, good_size, transform_of


class Spectra:
    """Sum over frames of |FFT|^2 of the winsorised frames, and the sum of these frames.

    The second is needed to take the DSNU out of the first:
    temporal power = (mean_n |Y_n|^2 - |mean_n Y_n|^2) K / (K - 1).
    """

    def __init__(self, plan: Plan) -> None:
        self.shape = good_size(plan.shape[0]), good_size(plan.shape[1])
        self.useful = min(self.shape) >= SMALLEST_SIDE
        self.frames = 0
        rows, columns = self.shape if self.useful else (0, 0)
        self.power_sum = np.zeros((rows, columns // 2 + 1))  # DN^2
        self.sum = np.zeros((rows, columns))  # DN, of the winsorised frames
        self._room: np.ndarray | None = None  # for a transform

    def add(self, view: FrameView) -> None:
        """Take in the next frame."""
        self.frames += 1
        if not self.useful:
            return
        from dnanalyze.analyzers.kernels import mode_loops

        centre = np.float32(view.plan.centre + view.shift)
        reach = np.float32(CLIP * view.plan.sigma)

        def clipped(rows: slice) -> np.ndarray:
            return mode_loops.add_clipped(self.sum[rows], view.frame[rows], centre, reach)

        self._add_power(self.power_sum, clipped, 1.0)

    def _add_power(
        self, total: np.ndarray, rows_of: Callable[[slice], np.ndarray], sign: float
    ) -> None:
        from dnanalyze.analyzers.kernels import mode_loops

        if self._room is None:
            self._room = np.empty(total.shape, np.complex64)
        mode_loops.add_power(total, transform_of(rows_of, self._room), sign / self.sum.size)

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {"_room": None}

    def merge(self, later: Self, seam: FrameView) -> None:
        """Take in the frames that follow mine."""
        self.frames += later.frames
        self.power_sum += later.power_sum
        self.sum += later.sum

    def frame_power(self) -> np.ndarray:
        """Mean power of the single frames, DN^2; (rows, columns // 2 + 1)."""
        return self.power_sum / self.frames

    def temporal_power(self) -> np.ndarray | None:
        """Power of the temporal noise, DN^2, same shape; None for one frame."""
        if self.frames < 2:
            return None
        power = self.frame_power()
        self._add_power(power, lambda r: (self.sum[r] / self.frames).astype(np.float32), -1.0)
        power *= self.frames / (self.frames - 1)
        return np.maximum(power, 0.0, out=power)
