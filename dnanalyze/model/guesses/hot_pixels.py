"""First guesses of hot_pixels: its parameters as the statistics suggest them."""

from __future__ import annotations

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.hot_pixels import HotPixels
from dnanalyze.model.guesses import hints
from dnanalyze.model.guesses.evidence import shows
from dnanalyze.model.guesses.hot_counts import USUAL, hot_signals
from dnanalyze.model.guesses.hot_peaks import hot_peaks


def guess(effect: type[HotPixels], clues: Clues) -> list[Effect]:
    """What the counts over thresholds tell, of all settings together and of each; before it the
    narrow peak of pixels that are alike, where one is seen.
    """
    if not shows(clues, [n for n in effect.fingerprint if n != "hot_repeat"]):
        return []
    return [*_narrow(effect, clues), *_spread(effect, clues)]


def _narrow(effect: type[HotPixels], clues: Clues) -> list[Effect]:
    first = [found[0] if found else None for found in hot_peaks(clues)]
    known = [peak for peak in first if peak is not None]
    amplitude = np.array([np.nan if peak is None else peak.amplitude for peak in first])
    fitted = hints.thermal_fit(clues, amplitude / hints.exposure_and_gain(clues), USUAL)
    if fitted is None:
        return []
    numbers = {
        "fraction": max(peak.share for peak in known),
        "scale": fitted[0],
        "ea_ev": fitted[1],
        "width": float(np.median([peak.width for peak in known])),
    }
    return [effect.within(**numbers, law="narrow")]


def _spread(effect: type[HotPixels], clues: Clues) -> list[Effect]:
    return [e for hot in hot_signals(clues) for e in effect.of_hot_signal(hot)]
