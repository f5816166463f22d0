"""Shrinkage of a fixed residual map by its signal-to-noise ratio in frequency bands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.stats import norm

from dnanalyze.significance import RARE

LOWEST_OCTAVE = 2  # log2 of the periods in the frame up to which modes share the lowest band
SMALLEST = 4  # modes of a band at the least: those of the lowest band along an axis
# Standard errors by which a band's power must exceed chance, so that one sensor in a thousand
# without structure keeps any of 36 bands (12 octaves, three kinds): 4.03.
POWER_ERRORS = float(norm.isf(RARE / 36))


def bands(shape: tuple[int, int]) -> np.ndarray:
    """Frequency band of each mode of `numpy.fft.rfft2`: octaves, the lowest of 1 to 4 periods.

    Means of whole columns (no vertical frequency) and of whole rows have bands of their own: fixed
    patterns of lines are there, and are lost among the modes of a ring. 0 is the mean.
    """
    v = np.abs(np.fft.fftfreq(shape[0]))[:, None]
    u = np.fft.rfftfreq(shape[1])[None, :]
    periods = np.hypot(u * shape[1], v * shape[0])
    octave = np.ceil(np.log2(np.maximum(periods, 1.0)) - 1e-9).astype(int)
    ring = np.maximum(octave - LOWEST_OCTAVE, 0)
    kind = np.where(v == 0, 1, np.where(u == 0, 2, 0))
    return np.where(periods == 0, 0, 1 + 3 * ring + kind)


def powers(maps: Sequence[np.ndarray], which: np.ndarray) -> np.ndarray:
    """Mean power of each of the `bands` over several maps, DN^2."""
    flat = which.ravel()
    count = np.maximum(np.bincount(flat), 1)
    total = sum(np.bincount(flat, (np.abs(np.fft.rfft2(m)) ** 2).ravel()) for m in maps)
    return np.asarray(total) / (len(maps) * count * maps[0].size)


def shrinkage(
    seen: np.ndarray, chance: np.ndarray, modes: np.ndarray, replicates: int
) -> np.ndarray:
    """Factor of each band, 0 to 1: what is left of a map when chance is taken off.

    The positive-part estimator of James and Stein (1961) for a mean of n numbers of known variance,
    1 - (n - 2) / n variance / mean square, with two numbers a mode; 0 for the mean, for bands of
    too few modes, and for those whose power does not exceed chance by `POWER_ERRORS` standard
    errors. ``chance``: mean power of ``replicates`` maps without structure.
    """
    n = 2.0 * modes
    with np.errstate(divide="ignore", invalid="ignore"):
        kept = 1.0 - (n - 2.0) / n * chance / seen
    error = chance * np.sqrt((1.0 + 1.0 / replicates) / np.maximum(modes, 1))
    significant = (modes >= SMALLEST) & (seen - chance > POWER_ERRORS * error)
    kept = np.where(significant, np.clip(kept, 0.0, 1.0), 0.0)
    kept[0] = 0.0
    return kept


def factors(seen: np.ndarray, chance: Sequence[np.ndarray]) -> np.ndarray:
    """Shrinkage of each mode of a map; ``chance``: maps of simulated sensors without structure."""
    which = bands((seen.shape[0], seen.shape[1]))
    modes = np.bincount(which.ravel())
    power, expected = powers([seen], which), powers(chance, which)
    return shrinkage(power, expected, modes, len(chance))[which]


def filtered(seen: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """A map with its modes multiplied by `factors`, float32."""
    made = np.fft.irfft2(np.fft.rfft2(seen) * kept, s=seen.shape)
    return made.astype(np.float32)
