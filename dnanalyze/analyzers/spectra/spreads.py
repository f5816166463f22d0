"""How much more than Gaussian noise heavy tails make the power of all modes scatter together."""

from __future__ import annotations

import numpy as np

from dnanalyze.analyzers.estimators.line_means import block_means
from dnanalyze.analyzers.estimators.quantiles import Ordered
from dnanalyze.analyzers.plan import CLIP

_SAMPLE = 1 << 18  # pixels from which the spread of heavy tails is taken
_TILE = 4  # pixels along a side that are taken together, for hits on several


def pattern_spread(pixels: Ordered, centre: float, sigma: float) -> float:
    """Relative variance of the winsorised pattern's power beyond that of Gaussian pixels.

    ``centre`` and ``sigma``, DN, are the pixels' median and robust sigma. From the influence of a
    pixel on the power, and on the interquartile range at whose multiple the pattern is cut (a
    quantile's influence is (p - [x < q]) dq/dp).
    """
    ordered = pixels.sorted
    x = ordered[:: max(1, ordered.size // _SAMPLE)] - np.float32(centre)
    reach = CLIP * sigma
    cut = float(np.mean(np.abs(x) >= reach))
    square = np.clip(x, -reach, reach).astype(float) ** 2
    power, n = float(square.mean()), x.size
    if power == 0:
        return 0.0
    square = square / power - 1
    q = pixels.quantile(np.array([0.2, 0.25, 0.3, 0.7, 0.75, 0.8]))
    low, high = (q[2] - q[0]) / 0.1, (q[5] - q[3]) / 0.1
    quarters = np.array([0.75 * low - 0.25 * high, -0.25 * (low + high), 0.75 * high - 0.25 * low])
    scale = quarters / max(q[4] - q[1], sigma) * (2 * reach**2 * cut / power)
    parts = np.array([p.sum() for p in np.split(square, [n // 4, 3 * n // 4])]) / n
    weight = np.array([0.25, 0.5, 0.25])
    variance = np.mean(square**2) + 2 * scale @ parts + weight @ scale**2
    return max(0.0, float(variance) - 2.0) / ordered.size


def tile_spread(image: np.ndarray) -> float:
    """Excess kurtosis of the means of 4 x 4 pixels over their number, not below 0."""
    rows, columns = (n // _TILE for n in image.shape)
    return excess_kurtosis(block_means(image[: rows * _TILE, : columns * _TILE], (rows, columns)))


def excess_kurtosis(means: np.ndarray) -> float:
    """Excess kurtosis over the number, not below 0."""
    x = (means - means.mean()) ** 2
    second = float(x.mean())
    return max(0.0, float(np.mean(x**2)) / second**2 - 3.0) / x.size if second > 0 else 0.0


def temporal_spread(
    variance: np.ndarray, pattern: np.ndarray, reach: float, cut: float, frames: int
) -> float:
    """Relative variance of the mean temporal variance beyond that of equal Gaussian pixels.

    Parameters
    ----------
    variance, pattern : ndarray
        Of each pixel over ``frames`` frames, DN^2; and its mean less the median, DN.
    reach, cut : float
        Pixels off the median by more than ``reach`` are left out; variances are cut at ``cut``
        squared; DN.
    """
    step = max(1, variance.size // _SAMPLE)
    step += 1 - step % 2
    seen, pattern = variance.ravel()[::step], pattern.ravel()[::step]
    inside = np.abs(pattern) < reach
    seen = np.where(inside, np.minimum(seen, np.float32(cut**2)), 0)
    mean = float(seen.mean(dtype=float))
    if mean == 0:
        return 0.0
    relative = float(seen.var(dtype=float)) / mean**2
    return max(0.0, relative - 2.0 / (frames - 1)) / variance.size
