"""First guesses of dark_shot_noise: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.dark_shot_noise import DarkShotNoise
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import shows


def guess(effect: type[DarkShotNoise], clues: Clues) -> list[Effect]:
    """Slope of temporal variance over mean, between settings and between pixels of a frame."""
    if not (shows(clues, effect.fingerprint) or shows(clues, effect.fingerprint, -1)):
        return []
    slopes = [s for s in (_slope_of_settings(clues), _slope_of_pixels(clues)) if s and s > 0]
    if len(slopes) == 2 and 0.5 < slopes[0] / slopes[1] < 2:
        slopes = slopes[:1]
    return [effect.within(dn_per_e=s) for s in slopes]


def _slope_of_settings(clues: Clues) -> float | None:
    mean, variance = hints.photon_transfer(clues)
    good = np.isfinite(mean) & np.isfinite(variance)
    if good.sum() < 2 or np.ptp(mean[good]) <= 0:
        return None
    weight = 1.0 / np.maximum(variance[good], 1e-12)  # relative errors are alike
    return float(np.polyfit(mean[good], variance[good], 1, w=weight)[0])


def _slope_of_pixels(clues: Clues) -> float | None:
    """Variance of the upper percent over that of the lower half, over their distance in level."""
    rise = clues.measured("noise_at_99") - clues.measured("noise_at_50")
    level = clues.measured("pattern_q0.99")  # above the median
    slope = rise / np.where(level > 0, level, np.nan) / hints.gains(clues)
    return float(np.nanmedian(slope)) if np.isfinite(slope).any() else None
