"""First guesses of temporal_denoise: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.quantization import ROUNDING_VARIANCE
from dnanalyze.model.effects.temporal_denoise import TemporalDenoise
from dnanalyze.model.guesses.evidence import curve, shows, typical_positive

UNLIKE = 1.1  # ratio of memories from which both are worth a look


def guess(effect: type[TemporalDenoise], clues: Clues) -> list[Effect]:
    """The memory from the lag-1 autocorrelation of the median pixel.

    About the mean of K frames it comes out near a (1 - 4/K) - 1/K (Kendall); the statistic has
    1/K added already, and the start of the recursion gives some back.
    """
    if not shows(clues, ["temporal_r1"]):
        return []
    r1 = clues.measured("temporal_r1")
    means = [curve(clues, "frame_means", i) for i in range(len(clues.points))]
    frames = max((m.size for m in means if m is not None), default=8)
    kept = max(0.35, 1.0 - 3.0 / frames)
    share = bounded(effect, "share", typical_positive(r1) / kept)
    noise = clues.measured("temporal_noise")
    # rounding after the filter is new in every frame: it hides least where noise is most
    most = int(np.argmax(np.where(np.isfinite(r1), np.nan_to_num(noise), 0.0)))
    less = 1.0 - min(ROUNDING_VARIANCE / max(noise[most], 1e-9) ** 2, 0.5)
    more = bounded(effect, "share", r1[most] / less / kept)
    shares = [share, more] if more > UNLIKE * share else [share]
    threshold = bounded(effect, "threshold", 4.0 * (typical_positive(noise) or 1.0))
    return [*map(effect, shares), effect(share, threshold, "on")]
