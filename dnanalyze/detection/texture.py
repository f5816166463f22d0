"""What edge-preserving filters do to the texture of noise: they leave some of it whole and smooth
the rest.

Each statistic is held against what independent pixels of the very same marginal give, so that heavy
tails or noisy pixels alone do not move it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dnanalyze.detection.flatten import clipped

SIDE = 4  # blocks of 4x4


@dataclass(frozen=True)
class Texture:
    """Unevenness of the noise.

    Parameters
    ----------
    dispersion : float
        Squared coefficient of variation of 4x4 variances over that of independent pixels; 1: none.
    dispersion_se : float
    hh_kurtosis : float
        Kurtosis of the finest diagonal Haar band, of the clipped image; 3 for Gaussian noise.
    hh_excess : float
        Over that of independent pixels.
    hh_se : float
    """

    dispersion: float
    dispersion_se: float
    hh_kurtosis: float
    hh_excess: float
    hh_se: float


def texture(images: np.ndarray) -> Texture:
    """From images (n, rows, columns) of temporal noise."""
    observed = expected = kurtosis = excess = 0.0
    blocks_seen = coefficients = 0
    for image in images:
        x = clipped(image, 4.0)
        h, w = (s // SIDE * SIDE for s in x.shape)
        x = x[:h, :w]
        centred = x - x.mean()
        squares = centred * centred
        square = float(squares.mean())
        if square <= 0:
            continue
        beyond = float(np.mean(squares * squares)) / square**2 - 3
        variances = x.reshape(h // SIDE, SIDE, w // SIDE, SIDE).var(axis=(1, 3), ddof=1)
        n = SIDE * SIDE
        observed += float(variances.var()) / float(variances.mean()) ** 2
        expected += beyond / n + 2 / (n - 1)
        hh = x[::2, ::2] - x[::2, 1::2] - x[1::2, ::2] + x[1::2, 1::2]
        hh *= hh
        here = float(np.mean(hh * hh)) / float(hh.mean()) ** 2
        kurtosis += here
        excess += here - (3 + beyond / 4)
        blocks_seen += variances.size
        coefficients += hh.size
    count = len(images)
    if not blocks_seen or expected <= 0:
        return Texture(1.0, np.inf, 3.0, 0.0, np.inf)
    return Texture(
        observed / expected,
        4.0 / np.sqrt(blocks_seen),
        kurtosis / count,
        excess / count,
        float(np.sqrt(24 / coefficients)) * 2,
    )


def equal_neighbours(stack: np.ndarray, reach: int = 3) -> tuple[float, float, int]:
    """Fraction of pixels equal to the right neighbour, and to the one ``reach`` columns away;
    pixels.

    A 3x3 median of continuous noise repeats .210 of its values to the right; the
    control holds the chance equality of rounded values.
    """
    own = float(np.mean(stack[:, :, 1:] == stack[:, :, :-1]))
    far = float(np.mean(stack[:, :, reach:] == stack[:, :, :-reach]))
    return own, far, stack.size
