"""Small maps of the field for drawing: at most 128 cells a side, whatever the sensor's size."""

from __future__ import annotations

import numpy as np

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.estimators.line_means import block_means

CELLS = 128  # a side
NAMES = ("mean", "fixed", "hot", "frame", "temporal")
SHADING = 15  # cells over which the slow shape of the field is taken off the nonuniformity


def pictures(acc: Accumulated) -> dict[str, np.ndarray]:
    """Maps of accumulated frames as curves ``picture_<name>``, float32, DN.

    Returns
    -------
    dict
        ``picture_mean`` : mean of the mean dark image over each cell.
        ``picture_fixed`` : one pixel of the mean dark image in each cell, less the mean of the
        cells around it: fine spatial nonuniformity at its full size. Two frames or more.
        ``picture_hot`` : highest pixel of each cell above the median, so that none is lost.
        ``picture_frame`` : one pixel of the first frame in each cell, at its full noise.
        ``picture_temporal`` : root mean square over each cell of the temporal standard deviation.
        Two frames or more.
    """
    shape = acc.plan.shape
    grid = min(shape[0], CELLS), min(shape[1], CELLS)
    middles = np.ix_(*(_middles(size, n) for size, n in zip(shape, grid, strict=True)))
    mean = block_means(acc.pattern, grid)
    found = {"mean": mean, "frame": acc.end_frames[0][middles]}
    found["hot"] = _highest(acc.pattern, grid) - acc.pattern_centre
    variance = acc.temporal_variance
    if variance is not None:
        found["temporal"] = np.sqrt(np.maximum(block_means(variance, grid), 0.0))
        smooth = _smoothed(block_means(acc.clipped_pattern, grid))
        found["fixed"] = acc.pattern[middles] - acc.pattern_centre - smooth
    return {
        f"picture_{name}": np.asarray(found[name], np.float32) for name in NAMES if name in found
    }


def _middles(size: int, cells: int) -> np.ndarray:
    """The middle pixel of each of nearly equal cells."""
    return (2 * np.arange(cells) + 1) * size // (2 * cells)


def _highest(image: np.ndarray, grid: tuple[int, int]) -> np.ndarray:
    edges = [np.arange(n) * size // n for n, size in zip(grid, image.shape, strict=True)]
    return np.asarray(np.maximum.reduceat(np.maximum.reduceat(image, edges[0]), edges[1], axis=1))


def _smoothed(cells: np.ndarray) -> np.ndarray:
    from scipy.ndimage import uniform_filter

    return np.asarray(uniform_filter(cells, SHADING, mode="nearest"))
