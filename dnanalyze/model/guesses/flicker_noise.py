"""First guesses of flicker_noise: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.flicker_noise import FlickerNoise
from dnanalyze.model.fingerprints import LINE_BANDS, centre
from dnanalyze.model.guesses.evidence import excess, power_law, shows, typical

_ALONG_ROW = ("0_0.03", "0.03_0.1", "0.1_0.3", "0.3_0.5")


def guess(effect: type[FlickerNoise], clues: Clues) -> list[Effect]:
    """A power law through the unexplained power of rows (f = v / columns) and of u (f = u)."""
    if not shows(clues, effect.fingerprint):
        return []
    rows, columns = clues.shape
    bands = [("temporal_rows", b, centre(b) / columns) for b in LINE_BANDS]
    bands += [("temporal_u", b, centre(b)) for b in _ALONG_ROW]
    names = [f"{prefix}_{band}" for prefix, band, _ in bands] + ["temporal_u_first"]
    f = np.array([*(f for _, _, f in bands), 2.0 / columns])
    power = np.array([typical(excess(clues, name)) for name in names])
    significant = np.array([shows(clues, [name], 1, 1.5) for name in names], float)
    constant, alpha = power_law(f, power, significant)
    if constant <= 0:
        return []
    alpha = bounded(effect, "alpha", alpha if significant.sum() > 2 else 1.0)
    pivot = int(np.argmax(significant * np.where(power > 0, power, 0)))
    constant = power[pivot] * f[pivot] ** alpha
    k = np.arange(1, rows * columns // 2 + 1) / (rows * columns)
    rms = math.sqrt(2.0 * constant * float(np.sum(k**-alpha)) / (rows * columns))
    return [effect(bounded(effect, "rms", rms), alpha)]
