"""First guesses of column_fpn: its parameters as the statistics suggest them."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np

from dnanalyze.model.bounds import bounded, clip
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
    numbers, left = _transient(clues)
    if not numbers:
        return [scattered]
    alone = bounded(effect, "sigma", math.sqrt(max(power[3], 0.0) / clues.shape[0]))
    settling = effect(alone, 0.0, **numbers)
    return [settling] if left < MOST_LEFT else [scattered, settling]


def _transient(clues: Clues) -> tuple[dict[str, Any], float]:
    """Exponentials a e^(-j/l) from one end, or from both, that fit the fitted half's column means.

    Numbers of the effect, and the share of the variance of the means that they leave. Least squares
    over a grid of lengths. None where they leave more than half of the variance, or where the
    length cannot be told from a slope. A second end is taken where it leaves `SECOND_LEFT` of what
    the first end alone leaves.
    """
    places, means = (part[: clues.shape[1]] for part in line_profile(clues, "columns"))
    if means.size < _FEWEST:
        return {}, 1.0
    blocks = means[: means.size // _BLOCK * _BLOCK].reshape(-1, _BLOCK).mean(axis=1)
    at = places[: blocks.size * _BLOCK].reshape(-1, _BLOCK).mean(axis=1)
    level = blocks - blocks.mean()
    smooth = np.vander(np.linspace(-1.0, 1.0, at.size), 3 if _has_bowl(clues) else 1)
    rest = level - smooth @ np.linalg.lstsq(smooth, level, rcond=None)[0]
    total = max(float(rest @ rest), 1e-30)
    lengths = np.geomspace(_BLOCK, 0.4 * means.size, 24)
    ends = at, clues.field[1] - 1 - at
    shapes = [np.exp(-np.subtract.outer(e, [e.min()]) / lengths) for e in ends]
    alone = {side: _fitted(level, smooth, [shapes[side]]) for side in (0, 1)}
    first = min(alone, key=lambda side: alone[side][0])
    left, found = alone[first]
    both = _fitted(level, smooth, [shapes[first], shapes[1 - first]])
    if both[0] < SECOND_LEFT * left:
        left, found = both
    if left > 0.5 * total or found[0][1] == lengths.size - 1:
        return {}, 1.0
    numbers: dict[str, Any] = {"first": ("left", "right")[first]}
    names = (("settle", "length"), ("edge", "edge_length"))
    for own, side, (height, n) in zip(names, (first, 1 - first), found, strict=False):
        start = float(ends[side].min())
        grown = math.exp(min(start / float(lengths[n]), 5.0))
        numbers |= clip(
            ColumnFpn, **dict(zip(own, (height * grown, float(lengths[n])), strict=True))
        )
    return numbers, left / total


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
    level: np.ndarray, smooth: np.ndarray, shapes: list[np.ndarray]
) -> tuple[float, list[tuple[float, int]]]:
    """Least sum of squares of one decay of each of these shapes, (places, lengths), beside
    ``smooth``; the height of each and the number of its length.
    """
    best: tuple[float, list[tuple[float, int]]] = (math.inf, [])
    for at in product(*(range(s.shape[1]) for s in shapes)):
        design = np.column_stack([smooth, *(s[:, n] for s, n in zip(shapes, at, strict=True))])
        normal, slope = design.T @ design, design.T @ level
        found = np.linalg.lstsq(normal, slope, rcond=None)[0]
        left = float(level @ level - slope @ found)
        if left < best[0]:
            heights = map(float, found[smooth.shape[1] :])
            best = left, list(zip(heights, at, strict=True))
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
