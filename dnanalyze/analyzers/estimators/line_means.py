"""Means of the rows, of the columns and of blocks of an image."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class LineMeans:
    """Means of lines, float64, and the variance of the pixels; units of the image."""

    columns: np.ndarray
    rows: np.ndarray
    variance: float


def line_means(image: np.ndarray, centre: float = 0.0, reach: float = np.inf) -> LineMeans:
    """Line means of a 2-D float32 image less ``centre``, cut to +-reach."""
    from dnanalyze.analyzers.kernels import mode_loops

    columns, rows, square = mode_loops.line_sums(image, np.float32(centre), np.float32(reach))
    columns, rows = columns / image.shape[0], rows / image.shape[1]
    return LineMeans(columns, rows, max(square / image.size - float(rows.mean()) ** 2, 0.0))


def block_means(image: np.ndarray, grid: tuple[int, int]) -> np.ndarray:
    """Means over a grid of nearly equal blocks, float64, of shape ``grid``."""
    edges = [np.arange(n + 1) * size // n for n, size in zip(grid, image.shape, strict=True)]
    by_row = np.add.reduceat(image, edges[1][:-1], axis=1)
    sums = np.add.reduceat(by_row, edges[0][:-1], axis=0, dtype=float)
    sizes = np.diff(edges[0])[:, None] * np.diff(edges[1])
    return np.asarray(sums / sizes)
