"""A few rows or columns unlike the others: in noise, in their level or in steps within them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from dnanalyze.description.found import Estimate, Sizes, random_sizes
from dnanalyze.description.layers import Layers
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.robust import robust_deviation
from dnanalyze.significance import CLEAR


def variance_lines(seen: Layers) -> list[Estimate]:
    """A share of the rows, or of the columns, with an additional noise."""
    if not seen.several:
        return []
    found = []
    for where, axis in (("row", 1), ("column", 0)):
        lines = [t.line_variances(axis) / t.noise**2 for t in seen.taken]
        mean = np.mean(lines, axis=0)
        middle = float(np.median(mean))
        error = robust_deviation(mean, middle)
        chosen = mean > middle + CLEAR * max(error, 1e-9)
        if not _few(chosen):
            continue
        excess = [x[chosen] - np.median(x[~chosen]) for x in lines]
        size = np.array([float(x.mean()) for x in excess]) * [t.noise**2 for t in seen.taken]
        scatter = np.array([robust_deviation(x) for x in lines]) / math.sqrt(chosen.sum())
        sizes = Sizes(size, scatter * [t.noise**2 for t in seen.taken], squares=True)
        gain = float(np.sum(((mean[chosen] - middle) / error) ** 2))
        words = {"what": "noise", "where": where, "distribution": "two_level"}
        found.append(_of_lines(seen, chosen, words, gain, sizes))
    return found


def changing_lines(seen: Layers) -> list[Estimate]:
    """A few rows or columns whose level changes from frame to frame."""
    found = []
    for where, axis in (("row", 2), ("column", 1)):
        means = [t.temporal.mean(axis=axis, dtype=float) for t in seen.taken]
        means = [m - np.median(m, axis=1, keepdims=True) for m in means]
        length = seen.taken[0].frames.shape[axis]
        chance = [
            max(t.noise**2 / length, robust_deviation(m, 0.0) ** 2)
            for t, m in zip(seen.taken, means, strict=True)
        ]
        score = sum(np.sum(m**2, axis=0) / c for m, c in zip(means, chance, strict=True))
        score = np.asarray(score, float)
        count = sum(len(m) - 1 for m in means)
        middle = float(np.median(score))
        error = max(math.sqrt(2.0 * count), robust_deviation(score, middle))
        chosen = score > middle + CLEAR * error
        if not _few(chosen):
            continue
        sizes, gain = random_sizes([m[:, chosen] for m in means], chance)
        values = np.concatenate([m[:, chosen].ravel() for m in means])
        two = _two_levels(values, np.array([len(m) for m in means]))
        words = {"where": where, "distribution": "two_level" if two else "normal"}
        found.append(_of_lines(seen, chosen, {"when": "frame"} | words, gain, sizes, count))
    return found


def segments(seen: Layers) -> list[Estimate]:
    """Lines that jump between two levels within a frame: bridges of their running sums."""
    found = []
    for where, axis in (("column_segments", 1), ("row_segments", 2)):
        scores, count = 0.0, 0
        for t in seen.taken:
            rest = t.temporal / np.float32(t.noise)
            length = rest.shape[axis]
            sums = np.cumsum(rest - rest.mean(axis=axis, keepdims=True), axis=axis)
            scores = scores + np.sum(np.mean((sums / math.sqrt(length)) ** 2, axis=axis), axis=0)
            count += len(rest) - 1
        score = np.asarray(scores, float) / (count + len(seen.taken))
        middle = float(np.median(score))
        # a squared Brownian bridge has mean 1/6 and variance 1/45 (Cramer and von Mises)
        error = max(math.sqrt(1 / 45 / count), robust_deviation(score, middle))
        chosen = score > middle + CLEAR * error
        if not _few(chosen):
            continue
        gain = float(np.sum(((score[chosen] - middle) / error) ** 2))
        values, errors = [], []
        for t in seen.taken:
            line = t.frames.var(axis=0, ddof=1, dtype=float).clip(0, (6 * t.noise) ** 2)
            by_line = line.mean(axis=axis - 1)
            values.append(float(by_line[chosen].mean() - np.median(by_line[~chosen])))
            scatter = float(by_line.std()) if chosen.sum() < 2 else float(by_line[chosen].std())
            errors.append(max(scatter / math.sqrt(chosen.sum()), 1e-9))
        sizes = Sizes(np.array(values), np.array(errors), squares=True)
        words = {"when": "frame", "where": where, "distribution": "two_level"}
        found.append(_of_lines(seen, chosen, words, gain, sizes, count))
    return found


def _few(chosen: np.ndarray) -> bool:
    """Whether some lines are chosen, and fewer than half of them: what most have is no defect."""
    return bool(0 < chosen.mean() < 0.5)


def _of_lines(
    seen: Layers,
    chosen: np.ndarray,
    words: dict[str, Any],
    gain: float,
    sizes: Sizes,
    count: int = 1,
) -> Estimate:
    """The structure of chosen lines. ``count``: independent frames that told each of them."""
    share = float(chosen.mean())
    first = seen.window.top if words["where"].startswith("row") else seen.window.left
    effect = CompositeEffect(share=share, lines=_runs(chosen, first), **words)
    spread = math.sqrt(share * (1 - share) / chosen.size)
    price = (float(chosen.sum()) + 2.0) * math.log(chosen.size * count)
    return Estimate(effect, {"share": spread}, gain, price, sizes)


def _runs(chosen: np.ndarray, first: int) -> tuple[float, ...]:
    """First and last line of each run of chosen ones, one pair after the other."""
    edges = np.diff(np.concatenate([[0], chosen.astype(int), [0]]))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1
    return tuple(float(n + first) for pair in zip(starts, ends, strict=True) for n in pair)


def _two_levels(values: np.ndarray, frames: np.ndarray) -> bool:
    """Whether values less the means of n frames are of two levels, by their fourth moment.

    Over the square of the second it is 3 of a normal distribution. Of two levels with k of n up, p
    = k / n, it is 16 E[p q (1 - 3 p q)] over (4 E[p q])^2: 1.6 of six frames.
    """
    if values.size < 200:  # the moment of so many normal values has an error of sqrt(24 / n) = .35
        return False
    n = max(int(np.median(frames)), 2)
    k = np.arange(n + 1)
    odds = np.array([math.comb(n, int(i)) for i in k]) / 2.0**n
    pq = k / n * (1.0 - k / n)
    two = float(odds @ (pq * (1.0 - 3.0 * pq))) / float(odds @ pq) ** 2
    ratio = float(np.mean(values**4) / np.mean(values**2) ** 2)
    return ratio < (two + 3.0) / 2.0
