"""The fixed offsets of lines as measured over all settings: facts that a guess takes as such."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.evidence import curve
from dnanalyze.model.hints import gains

MAD = 1.4826  # median absolute deviation to standard deviation of a Gaussian


def robust_deviation(values: np.ndarray) -> float:
    """Standard deviation by the median absolute deviation."""
    return float(MAD * np.median(np.abs(values - np.median(values))))


def line_profile(clues: Clues, axis: str) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the lines in the full frame, and their offsets at the reference gain, DN.

    Parameters
    ----------
    clues : Clues
    axis : str
        "columns" or "rows".

    Returns
    -------
    places, offsets : ndarray
        The mean over the settings, the quieter ones weighing more (the inverse of the variance
        from line to line): dark current scatters, offsets of the readout do not. Empty where no
        setting has them.
    """
    places, sums, weights = np.empty(0, int), np.empty(0), 0.0
    for setting, gain in enumerate(gains(clues)):
        places_here, means = clues.lines(axis, setting)
        if means.size < 2:
            continue
        weight = gain**2 / max(robust_deviation(np.diff(means)) ** 2, 1e-12)
        places, sums = places_here, (sums if sums.size else 0.0) + weight * means / gain
        weights += weight
    return places, sums / weights if weights else sums


def strip_profile(clues: Clues) -> np.ndarray:
    """Means over all rows of the field of the columns of its blocks, at the reference gain, DN."""
    sums, weights = np.empty(0), 0.0
    for setting, gain in enumerate(gains(clues)):
        blocks = curve(clues, "block_means", setting)
        if blocks is None or blocks.ndim != 2 or not np.isfinite(blocks).all():
            continue
        means = blocks.mean(axis=0) - blocks.mean()
        weight = gain**2 / max(robust_deviation(np.diff(means)) ** 2, 1e-12)
        sums = (sums if sums.size else 0.0) + weight * means / gain
        weights += weight
    return sums / weights if weights else sums
