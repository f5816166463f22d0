"""The fixed offsets of lines as measured over all settings: facts that a guess takes as such."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.guesses.evidence import curve
from dnanalyze.model.guesses.hints import gains
from dnanalyze.robust import robust_deviation


def line_profile(clues: Clues, axis: str) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the lines in the full frame, and their offsets at the reference gain, DN.

    ``axis``: "columns" or "rows". Empty where no setting has them.
    """
    seen = [clues.lines(axis, setting) for setting in range(len(clues.points))]
    places = next((places for places, means in seen if means.size > 1), np.empty(0, int))
    return places, _quiet_mean(clues, [means for _, means in seen])


def strip_profile(clues: Clues) -> np.ndarray:
    """Means over all rows of the field of the columns of its blocks, at the reference gain, DN."""
    seen = []
    for setting in range(len(clues.points)):
        blocks = curve(clues, "block_means", setting)
        usable = blocks is not None and blocks.ndim == 2 and np.isfinite(blocks).all()
        seen.append(blocks.mean(axis=0) - blocks.mean() if usable else np.empty(0))  # type: ignore[union-attr]
    return _quiet_mean(clues, seen)


def _quiet_mean(clues: Clues, seen: list[np.ndarray]) -> np.ndarray:
    """Mean of a profile over the settings that have it, at the reference gain.

    The quieter weigh more (the inverse of the variance from line to line): dark current scatters,
    offsets of the readout do not.
    """
    sums, weights = np.empty(0), 0.0
    for means, gain in zip(seen, gains(clues), strict=True):
        if means.size < 2:
            continue
        weight = gain**2 / max(robust_deviation(np.diff(means)) ** 2, 1e-12)
        sums = (sums if sums.size else 0.0) + weight * means / gain
        weights += weight
    return sums / weights if weights else sums
