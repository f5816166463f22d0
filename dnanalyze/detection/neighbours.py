"""Kernels over a pixel and its ring of neighbours; edges are left out."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def ring_maximum(image: np.ndarray, reach: int) -> np.ndarray:
    """Largest of the (2 reach + 1)^2 - 1 neighbours; (rows - 2r, columns - 2r)."""
    h, w = image.shape
    top = np.empty((h - 2 * reach, w - 2 * reach), image.dtype)
    for y in range(reach, h - reach):
        for x in range(reach, w - reach):
            most = image[y - 1, x]
            for dy in range(-reach, reach + 1):
                for dx in range(-reach, reach + 1):
                    if dy != 0 or dx != 0:
                        most = max(most, image[y + dy, x + dx])
            top[y - reach, x - reach] = most
    return top


@njit(cache=True, nogil=True)
def exceedances(image: np.ndarray, dy: np.ndarray, dx: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Per row, how many pixels lie above, and below, all the neighbours at offsets (dy, dx).

    The pixels looked at are those whose neighbours all lie in the frame.
    """
    h, w = image.shape
    my, mx = np.abs(dy).max(), np.abs(dx).max()
    above = np.zeros(h, np.int64)
    below = np.zeros(h, np.int64)
    for y in range(my, h - my):
        for x in range(mx, w - mx):
            v = image[y, x]
            is_top = True
            is_low = True
            for n in range(dy.size):
                other = image[y + dy[n], x + dx[n]]
                is_top = is_top and v > other
                is_low = is_low and v < other
                if not (is_top or is_low):
                    break
            above[y] += is_top
            below[y] += is_low
    return above, below
