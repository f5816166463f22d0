"""First guesses of column_fpn: its parameters as the statistics suggest them."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.model.bounds import bounded
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect
from dnanalyze.model.effects.column_fpn import ColumnFpn
from dnanalyze.model.fingerprints import centre
from dnanalyze.model.guesses.evidence import band_excess, line_sigma, shows, typical
from dnanalyze.model.guesses.line_profile import line_profile

_BLOCK = 4  # columns that are averaged before a transient is fitted
_FEWEST = 64  # columns from which one is looked for
MOST_LEFT = 0.2  # share of the variance left by a transient beside which no scatter is tried


def guess(effect: type[ColumnFpn], clues: Clues) -> list[Effect]:
    """sigma from the unexplained power of the v = 0 axis, rho from its slope; a transient from
    the column means, where one explains most of them.
    """
    if not shows(clues, effect.fingerprint):
        return []
    sigma = line_sigma(clues, "pattern_columns", clues.shape[0])
    power = [typical(row) for row in band_excess(clues, "pattern_columns")]
    rho = _correlation(power[1], power[3])
    scattered = effect(bounded(effect, "sigma", sigma), rho)
    transient, left = _transient(clues)
    if transient is None:
        return [scattered]
    alone = bounded(effect, "sigma", math.sqrt(max(power[3], 0.0) / clues.shape[0]))
    settling = effect(alone, 0.0, *transient)
    return [settling] if left < MOST_LEFT else [scattered, settling]


def _transient(clues: Clues) -> tuple[tuple[float, float, str] | None, float]:
    """Offset of the first column (DN), length (columns) and side of an exponential settling; the
    share of the variance that it leaves.

    Least squares of c + a e^(-j/l) on the fitted half's column means over a grid of lengths. None
    where it leaves more than half of their variance, or where the length cannot be told from a
    slope.
    """
    places, means = (part[: clues.shape[1]] for part in line_profile(clues, "columns"))
    if means.size < _FEWEST:
        return None, 1.0
    blocks = means[: means.size // _BLOCK * _BLOCK].reshape(-1, _BLOCK).mean(axis=1)
    at = places[: blocks.size * _BLOCK].reshape(-1, _BLOCK).mean(axis=1)
    level = blocks - blocks.mean()
    total = max(float(level @ level), 1e-30)
    best = (0.5 * total, 0.0, 0.0, "")
    longest = 0.4 * means.size
    for first in ("left", "right"):
        order = at if first == "left" else clues.field[1] - 1 - at
        for length in np.geomspace(_BLOCK, longest, 24):
            decay = np.exp(-(order - order.min()) / length)
            shape = decay - decay.mean()
            height = float(shape @ level / (shape @ shape))
            left = float(np.sum((level - height * shape) ** 2))
            if left < best[0]:
                start = height * math.exp(min(float(order.min()) / length, 5.0))
                best = left, start, float(length), first
    left, start, length, first = best
    return ((start, length, first) if 0.0 < length < longest else None), left / total


def _correlation(low: float, high: float) -> float:
    """rho whose spectrum (1 - rho^2) / |1 - rho e^(i w)|^2 has this ratio between two bands."""
    if low <= 0 or high <= 0 or 0.5 < low / high < 2.0:
        return 0.0
    rho = np.linspace(-0.9, 0.95, 371)
    ratio = _shape(rho, centre("0.3_0.5")) / _shape(rho, centre("0.02_0.1"))
    return float(rho[np.argmin(np.abs(np.log(ratio) - math.log(low / high)))])


def _shape(rho: np.ndarray, frequency: float) -> np.ndarray:
    """|1 - rho e^(2 pi i f)|^2."""
    return 1.0 - 2.0 * rho * math.cos(2.0 * math.pi * frequency) + rho * rho
