"""The halo around isolated hot pixels: what share of their excess their neighbours carry."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.analyzers.statistics import Value

HOT_SIGMAS = 16.0
FEWEST = 10
_MOST = 4096  # hot pixels looked at
_REACH = 3  # pixels; the ring at this distance is the local background
_OTHER_SIGMAS = 5.0  # another pixel in reach above this, or a quarter of the amplitude, spoils it
_OTHER_SHARE = 0.25


def halo(pattern: np.ndarray, centre: float, sigma: float) -> dict[int, Value]:
    """Mean of the rings at distance 1 and 2 less the background, over the amplitude.

    Parameters
    ----------
    pattern : ndarray of float32
        (rows, columns), DN.
    centre, sigma : float
        Median and robust sigma of its lower half, DN.

    Returns
    -------
    dict
        Distance (1: the 8 neighbours, 2: the 16 around them) to the value; empty with fewer than 10
        isolated pixels above 16 sigma.
    """
    r, n = _REACH, 2 * _REACH + 1
    if min(pattern.shape) < n:
        return {}
    inner = pattern[r:-r, r:-r]
    y, x = np.divmod(np.flatnonzero(inner > centre + HOT_SIGMAS * sigma), inner.shape[1])
    if y.size < FEWEST:
        return {}
    if y.size > _MOST:
        chosen = np.linspace(0, y.size - 1, _MOST).astype(int)
        y, x = y[chosen], x[chosen]
    offset = np.arange(n)
    patch = pattern[y[:, None, None] + offset[:, None], x[:, None, None] + offset].astype(float)
    distance = np.maximum(*np.abs(np.indices((n, n)) - r))
    background = patch[:, distance == r].mean(axis=1)
    amplitude = patch[:, r, r] - background
    highest = patch[:, distance > 0].max(axis=1) - background
    limit = np.maximum(_OTHER_SIGMAS * sigma, _OTHER_SHARE * amplitude)
    alone = (highest < limit) & (amplitude > 0)
    if alone.sum() < FEWEST:
        return {}
    patch, amplitude, background = patch[alone], amplitude[alone], background[alone]
    out = {}
    for ring in (1, 2):
        excess = patch[:, distance == ring].mean(axis=1) - background
        # rings 1 and 2 share the background of ring 3, so that a flat field gives 0
        share = float(excess.sum() / amplitude.sum())
        scatter = float(np.sum((excess - share * amplitude) ** 2)) * alone.sum() / (alone.sum() - 1)
        floor = 1e-6 * float(amplitude.sum())
        out[ring] = Value(share, max(math.sqrt(scatter), floor) / float(amplitude.sum()))
    return out
