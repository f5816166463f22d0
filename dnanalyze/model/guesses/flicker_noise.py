"""First guesses of flicker_noise: its parameters as the statistics suggest them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.flicker_noise import FlickerNoise
from dnanalyze.model.fingerprints import LINE_BANDS, centre
from dnanalyze.model.guesses.evidence import excess, power_law, shows, typical

# The lowest bands of the rows lie a factor of 6 apart: 1/f^alpha rises by 6^alpha, 1.7 at least.
_RISING = 1.5
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
    plain = effect(bounded(effect, "rms", _rms(rows * columns, constant, alpha, 0.0)), alpha)
    guesses: list[Effect] = [plain]
    cut = _cutoff(f, power, significant)
    if cut is not None:
        constant, alpha, cutoff = cut
        alpha = bounded(effect, "alpha", alpha)
        rms = _rms(rows * columns, constant, alpha, cutoff)
        guesses.insert(0, effect.within(rms=rms, alpha=alpha, cutoff=cutoff))
    middle, high = (names.index(f"temporal_u_{b}") for b in _ALONG_ROW[-2:])
    # of one chain the power falls with the frequency; of two that at u is that at 1/2 - u too
    if significant[high] and power[high] > power[middle]:
        guesses.insert(0, replace(plain, chains=2))
    return guesses


def _rms(count: int, constant: float, alpha: float, cutoff: float) -> float:
    """Standard deviation over a frame of so many pixel periods, DN."""
    k = np.maximum(np.arange(1, count // 2 + 1) / count, cutoff)
    return math.sqrt(2.0 * constant * float(np.sum(k**-alpha)) / count)


def _cutoff(
    f: np.ndarray, power: np.ndarray, significant: np.ndarray
) -> tuple[float, float, float] | None:
    """Constant and exponent along the row, and the frequency where the law meets the power of the
    rows; None where that goes on rising to the lowest frequency, or is not seen.
    """
    lines, seen = len(LINE_BANDS), significant > 0
    low, near = power[0], power[1]
    if not (seen[:2].all() and seen[lines:].sum() >= 3 and 0 < low < _RISING * near):
        return None
    along = seen & (np.arange(f.size) >= lines)
    constant, alpha = power_law(f, power, along.astype(float))
    if constant <= 0 or alpha < FlickerNoise.parameters()["alpha"].lower:
        return None
    cutoff = float((constant / np.sqrt(low * near)) ** (1.0 / alpha))
    return constant, alpha, cutoff if cutoff < 0.5 else 0.5
