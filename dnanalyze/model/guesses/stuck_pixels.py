"""First guesses of stuck_pixels: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.stuck_pixels import StuckPixels
from dnanalyze.model.guesses.evidence import curve, excess, shows, strongest, typical_positive


def guess(effect: type[StuckPixels], clues: Clues) -> list[Effect]:
    """The share from pixels without temporal variance; the code at which most of them stand, or
    where none stands out both ends of what occurs.

    Where the noise is below a code many pixels never change, and what piles up at the ends of
    the histogram and stands far off in the pattern tells.
    """
    if shows(clues, ["dead_count"]):
        count = typical_positive(excess(clues, "dead_count"))
    elif shows(clues, ["low_spike", "high_spike"]):
        far = ("hot_count_64", "cold_count_8")
        count = sum(typical_positive(excess(clues, name)) for name in far)
    else:
        return []
    fraction = bounded(effect, "fraction", count / (clues.shape[0] * clues.shape[1]))
    setting = strongest(clues, ["dead_count"]) or 0
    stuck = curve(clues, "dead_codes", setting)
    if stuck is not None:
        most, top = (bounded(effect, "code", float(c)) for c in (stuck[0], np.max(stuck)))
        return [effect(fraction, top, "any"), effect(fraction, most)]
    codes = curve(clues, "histogram_codes", setting)
    ends = (0.0, 4095.0) if codes is None else (float(np.min(codes)), float(np.max(codes)))
    low, high = (bounded(effect, "code", end) for end in ends)
    return [effect(fraction, high, "any"), effect(fraction, high), effect(fraction, low)]
