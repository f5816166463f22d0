"""Low-order surfaces over the field, in Legendre polynomials of unit rms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from dnanalyze.model.effect import Site

GRID = 64
TERMS = ("x", "y", "xx", "yy", "xy")


def low_order(coefficients: Sequence[float], site: Site) -> np.ndarray:
    """Surface over the site's window, coefficients in the order of ``TERMS``.

    Parameters
    ----------
    coefficients : sequence of float
        Each the rms of its term over the whole field.
    site : Site

    Returns
    -------
    ndarray
        (rows, columns), float64; zero mean over the whole field.
    """
    x, y, xx, yy, xy = coefficients
    across, wide = legendre(site.column_index, site.shape[1])
    down, high = legendre(site.row_index, site.shape[0])
    surface: np.ndarray = (y * down + yy * high)[:, None] + x * across + xx * wide
    if xy != 0.0:
        surface += np.outer(xy * down, across)
    return surface


def median_of(coefficients: Sequence[float]) -> float:
    """Median of a surface over the whole field, from `GRID` points along each side."""
    p, q = legendre(np.arange(GRID), GRID)
    x, y, xx, yy, xy = coefficients
    surface = x * p + xx * q + (y * p + yy * q)[:, None] + xy * np.outer(p, p)
    return float(np.median(surface))


def legendre(index: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """First and second Legendre polynomial of unit rms at the pixel centres of ``size`` pixels."""
    x = (2.0 * np.asarray(index) + 1.0) / size - 1.0
    return np.sqrt(3.0) * x, np.sqrt(5.0) * (1.5 * x * x - 0.5)
