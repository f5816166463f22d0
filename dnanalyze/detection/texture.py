"""What edge-preserving filters do to the texture of noise: they leave some of it whole and smooth
the rest.

Each statistic is held against what independent pixels of the very same marginal give, so that heavy
tails or noisy pixels alone do not move it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.kernels.layout import TILE
from dnanalyze.detection.flatten import clipped
from dnanalyze.significance import NOTICEABLE


@dataclass(frozen=True)
class Texture:
    """Unevenness of the noise."""

    # Squared coefficient of variation of 4x4 variances over that of independent pixels; 1: none.
    dispersion: float
    dispersion_se: float
    # Kurtosis of the finest diagonal Haar band, of the clipped image; 3 for Gaussian noise.
    hh_kurtosis: float
    hh_excess: float  # over that of independent pixels
    hh_se: float


def texture(images: np.ndarray) -> Texture:
    """From images (n, rows, columns) of temporal noise."""
    found = [of for of in map(_of_image, images) if of is not None]
    if not found:
        return Texture(1.0, np.inf, 3.0, 0.0, np.inf)
    observed, expected, kurtosis, excess = np.mean(found, axis=0)
    rows, columns = (n // TILE for n in images.shape[1:])
    tiles = len(found) * rows * columns
    # twice the standard errors of Gaussian noise: its tails are heavier
    dispersion_se, hh_se = 4.0 / math.sqrt(tiles), 2 * math.sqrt(24 / (tiles * TILE))
    return Texture(observed / expected, dispersion_se, kurtosis, excess, hh_se)


def _of_image(image: np.ndarray) -> tuple[float, float, float, float] | None:
    """Dispersion of tiles, that of independent pixels, Haar kurtosis, excess of it over theirs."""
    rows, columns = (n // TILE * TILE for n in image.shape)
    x = clipped(image, NOTICEABLE)[:rows, :columns]
    if not np.ptp(x) > 0:
        return None
    beyond = _kurtosis(x - x.mean()) - 3
    tiles = x.reshape(rows // TILE, TILE, columns // TILE, TILE)
    variances = tiles.var(axis=(1, 3), ddof=1)
    pixels = TILE * TILE
    observed = float(variances.var()) / float(variances.mean()) ** 2
    haar = _kurtosis(x[::2, ::2] - x[::2, 1::2] - x[1::2, ::2] + x[1::2, 1::2])
    return observed, beyond / pixels + 2 / (pixels - 1), haar, haar - (3 + beyond / 4)


def _kurtosis(x: np.ndarray) -> float:
    """Fourth moment about 0 over the square of the second."""
    squares = x * x
    return float(np.mean(squares * squares)) / float(squares.mean()) ** 2


def equal_neighbours(stack: np.ndarray, reach: int = 3) -> tuple[float, float, int]:
    """Fraction of pixels equal to the right neighbour, to the one ``reach`` columns away; pixels.

    A 3x3 median of continuous noise repeats .210 of its values to the right; the
    control holds the chance equality of rounded values.
    """
    own = float(np.mean(stack[:, :, 1:] == stack[:, :, :-1]))
    far = float(np.mean(stack[:, :, reach:] == stack[:, :, :-reach]))
    return own, far, stack.size
