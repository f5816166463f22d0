"""First guesses of flicker_fpn: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model import pink
from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.flicker_fpn import FlickerFpn
from dnanalyze.model.fingerprints import BANDS, centre, named
from dnanalyze.model.guesses.evidence import (
    band_excess,
    over_signal,
    power_law,
    shows,
    typical,
)


def guess(effect: type[FlickerFpn], clues: Clues) -> list[Effect]:
    """A power law through the unexplained axis-masked power."""
    prefix = "pattern_psd"
    if not np.any(np.isfinite(clues.measured("pattern_psd_0.04_0.08"))):
        prefix = "frame_psd"
    if not shows(clues, named(prefix, BANDS[:5])):
        return []
    excess = band_excess(clues, prefix, BANDS)
    seen = np.array([shows(clues, [name], 1, 1.5) for name in named(prefix, BANDS)], float)
    guesses: list[Effect] = []
    offset = _law(np.array([typical(row) for row in excess]), seen, clues.shape)
    if offset is not None:
        guesses.append(effect.within(rms=offset[0], alpha=offset[1]))
    share = _law(_shares(clues, excess), seen, clues.shape)
    if share is not None and share[0] < 1.0:
        guesses.append(effect.within(rms=share[0], alpha=share[1], form="scaled"))
    return guesses


def _shares(clues: Clues, excess: np.ndarray) -> np.ndarray:
    """Power of each band over the square of the dark signal: least squares over the settings.

    Zeros where the level hardly moves.
    """
    both = over_signal(clues, excess)
    if both is None:
        return np.zeros(len(excess))
    square, power = both[0] ** 2, both[1]
    return np.asarray(power @ square / float(square @ square))


def _law(power: np.ndarray, seen: np.ndarray, shape: tuple[int, int]) -> tuple[float, float] | None:
    """Spread and exponent of a field of this power in the bands; None without any power."""
    frequency = np.array([centre(band) for band in BANDS])
    constant, alpha = power_law(frequency, power, seen)
    if constant <= 0:
        constant, alpha = max(power[:5].max(), 0.0) * frequency[int(power[:5].argmax())], 1.0
    if constant <= 0:
        return None
    held = bounded(FlickerFpn, "alpha", alpha)
    pivot = float(np.exp(np.average(np.log(frequency), weights=seen + 1e-9)))
    constant *= pivot ** (held - alpha)
    return math.sqrt(constant * pink.mean_power(shape, held)), held
