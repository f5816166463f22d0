"""Means of the rows, of the columns and of blocks of an image."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

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
    rows, columns, sizes = _blocks(grid, (image.shape[0], image.shape[1]))
    by_row = np.add.reduceat(image, columns, axis=1)
    return np.asarray(np.add.reduceat(by_row, rows, axis=0, dtype=float) / sizes)


@lru_cache(maxsize=64)
def _blocks(
    grid: tuple[int, int], shape: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First row and first column of the blocks, and their pixels."""
    edges = [np.arange(n + 1) * size // n for n, size in zip(grid, shape, strict=True)]
    return edges[0][:-1], edges[1][:-1], np.diff(edges[0])[:, None] * np.diff(edges[1])
