"""First guesses of column_fpn: its parameters as the statistics suggest them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product
from typing import Any

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
# Share of the squares left by one end, below which both ends are taken: two numbers more explain
# 2 of some 100 blocks of chance, 2 %
SECOND_LEFT = 0.8
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
    transient = _transient(clues)
    if transient is None:
        return [scattered]
    alone = bounded(effect, "sigma", math.sqrt(max(power[3], 0.0) / clues.shape[0]))
    settling = effect(alone, 0.0, **transient.numbers)
    return [settling] if transient.left < MOST_LEFT else [scattered, settling]


@dataclass(frozen=True)
class _Transient:
    """Offsets that decay from the first columns, or from both ends.

    ``numbers``: those of the effect. ``left``: share of the variance of the column means that they
    leave.
    """

    numbers: dict[str, Any]
    left: float


def _transient(clues: Clues) -> _Transient | None:
    """Exponentials a e^(-j/l) from one end, or from both, that fit the fitted half's column means.

    Least squares over a grid of lengths. None where they leave more than half of the variance of
    the means, or where the length cannot be told from a slope. A second end is taken where it
    leaves `SECOND_LEFT` of what the first end alone leaves.
    """
    places, means = (part[: clues.shape[1]] for part in line_profile(clues, "columns"))
    if means.size < _FEWEST:
        return None
    blocks = means[: means.size // _BLOCK * _BLOCK].reshape(-1, _BLOCK).mean(axis=1)
    at = places[: blocks.size * _BLOCK].reshape(-1, _BLOCK).mean(axis=1)
    level = blocks - blocks.mean()
    smooth = np.vander(np.linspace(-1.0, 1.0, at.size), 3 if _has_bowl(clues) else 1)
    rest = level - smooth @ np.linalg.lstsq(smooth, level, rcond=None)[0]
    total = max(float(rest @ rest), 1e-30)
    lengths = np.geomspace(_BLOCK, 0.4 * means.size, 24)
    ends = at, clues.field[1] - 1 - at
    shapes = [np.exp(-np.subtract.outer(e, [e.min()]) / lengths) for e in ends]
    fits = [_fitted(level, smooth, shapes, lengths, (side,)) for side in (0, 1)]
    one = min(fits, key=lambda f: f[0])
    both = _fitted(level, smooth, shapes, lengths, (one[1][0].side, 1 - one[1][0].side))
    left, found = both if both[0] < SECOND_LEFT * one[0] else one
    if left > 0.5 * total or found[0].length >= lengths[-1]:
        return None
    numbers: dict[str, Any] = {"first": ("left", "right")[found[0].side]}
    for names, decay in zip((("settle", "length"), ("edge", "edge_length")), found, strict=False):
        start = float(ends[decay.side].min())
        height = decay.height * math.exp(min(start / decay.length, 5.0))
        numbers |= zip(names, (height, decay.length), strict=True)
    return _Transient(numbers, left / total)


@dataclass(frozen=True)
class _Decay:
    """An exponential from the left end, side 0, or the right one; DN and columns."""

    side: int
    height: float
    length: float


def _has_bowl(clues: Clues) -> bool:
    """Whether the model has at least half of the tilt or bowl of the columns that is measured.

    The transients are then those beside it.
    """
    for name in ("shading_1_0", "shading_2_0"):
        seen, model = (
            np.abs(np.asarray(of(name), float)) for of in (clues.measured, clues.simulated)
        )
        if typical(model) > 0.5 * typical(seen):
            return True
    return False


def _fitted(
    level: np.ndarray,
    smooth: np.ndarray,
    shapes: list[np.ndarray],
    lengths: np.ndarray,
    sides: tuple[int, ...],
) -> tuple[float, list[_Decay]]:
    """Least sum of squares of decays from these ends beside ``smooth``, and the decays; their best
    lengths.
    """
    best: tuple[float, list[_Decay]] = (math.inf, [])
    for at in product(range(len(lengths)), repeat=len(sides)):
        columns = [shapes[side][:, n] for side, n in zip(sides, at, strict=True)]
        design = np.column_stack([smooth, *columns])
        normal, slope = design.T @ design, design.T @ level
        found = np.linalg.lstsq(normal, slope, rcond=None)[0]
        left = float(level @ level - slope @ found)
        if left < best[0]:
            heights = map(float, found[smooth.shape[1] :])
            decays = zip(sides, heights, (float(lengths[n]) for n in at), strict=True)
            best = left, [_Decay(*d) for d in decays]
    return best


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
