"""Sums of the frames' Fourier powers: the spectra of single frames and of the temporal noise."""

from __future__ import annotations

from typing import Self

import numpy as np
import scipy.fft

from dnanalyze.analyzers.plan import CLIP, FrameView, Plan
from dnanalyze.analyzers.spectral_modes import SMALLEST_SIDE, good_size, power_of


class Spectra:
    """Sum over frames of |FFT|^2 of the winsorised frames, and the sum of these frames.

    The second is needed to take the fixed pattern out of the first:
    temporal power = (mean_n |Y_n|^2 - |mean_n Y_n|^2) K / (K - 1).
    """

    def __init__(self, plan: Plan) -> None:
        self.shape = good_size(plan.shape[0]), good_size(plan.shape[1])
        self.useful = min(self.shape) >= SMALLEST_SIDE
        self.frames = 0
        rows, columns = self.shape if self.useful else (0, 0)
        self.power_sum = np.zeros((rows, columns // 2 + 1))  # DN^2
        self.sum = np.zeros((rows, columns))  # DN, of the winsorised frames
        self._clipped = np.empty((rows, columns), np.float32)

    def add(self, view: FrameView) -> None:
        """Take in the next frame."""
        self.frames += 1
        if not self.useful:
            return
        from dnanalyze.analyzers import spectral_kernels as kernels

        rows, columns = self.shape
        plan = view.plan
        reach = np.float32(CLIP * plan.sigma)
        kernels.add_clipped(self.sum, view.frame, np.float32(plan.centre), reach, self._clipped)
        transform = scipy.fft.rfft2(self._clipped)
        kernels.add_power(self.power_sum, transform, 1.0 / (rows * columns))

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
        mean = np.empty(self.shape, np.float32)
        np.divide(self.sum, self.frames, out=mean, casting="same_kind")
        power -= power_of(mean, self.shape)
        power *= self.frames / (self.frames - 1)
        return np.maximum(power, 0.0, out=power)
