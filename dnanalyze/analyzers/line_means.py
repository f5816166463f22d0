"""Means of the rows and columns of an image, in one go."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class LineMeans:
    """Means of lines, float64, and the variance of the pixels; units of the image."""

    columns: np.ndarray
    rows: np.ndarray
    variance: float


def line_means(image: np.ndarray) -> LineMeans:
    """Line means of a 2-D float32 image."""
    from dnanalyze.analyzers import spectral_kernels as kernels

    columns, rows, square = kernels.line_sums(image)
    columns, rows = columns / image.shape[0], rows / image.shape[1]
    return LineMeans(columns, rows, max(square / image.size - float(rows.mean()) ** 2, 0.0))
