"""A few rows or columns unlike the others: in noise, in their level or in steps within them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from dnanalyze.description.found import Estimate, Sizes, distribution, random_sizes
from dnanalyze.description.layers import Layers, robust
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.model.effects.quantization import ROUNDING_VARIANCE
from dnanalyze.robust import robust_deviation
from dnanalyze.significance import CLEAR, STATED

LINES = (("row", 1), ("column", 0))  # and the axis along them
BRIDGE_VARIANCE = 1 / 45  # of a squared Brownian bridge of mean 1/6 (Cramer and von Mises)
COLUMN_SHARE = 0.25  # correlation along the rows over that along the columns: crosstalk has 1


def few_lines(seen: Layers) -> Iterator[Estimate]:
    """Rows or columns that are noisier, change their level, or jump within a frame."""
    for where, axis in LINES:
        for found in (
            _noisy(seen, where, axis),
            _changing(seen, where, axis),
            _jumping(seen, where, axis),
        ):
            if found is not None:
                yield found


def _noisy(seen: Layers, where: str, axis: int) -> Estimate | None:
    """Lines with an additional noise."""
    score = np.mean([t.line_variances(axis) / t.noise**2 for t in seen.taken], axis=0)
    chosen, gain = _outliers(score, 1e-9)
    if not chosen.any():
        return None
    words = {"what": "noise", "where": where, "distribution": "two_level"}
    return _of_lines(seen, chosen, words, gain, _more_variance(seen, axis, chosen))


def _changing(seen: Layers, where: str, axis: int) -> Estimate | None:
    """Lines whose level changes from frame to frame."""
    means = [t.temporal.mean(axis=axis + 1, dtype=float) for t in seen.taken]
    means = [m - np.median(m, axis=1, keepdims=True) for m in means]
    chance = [
        max(t.noise**2 / seen.window.shape[axis], robust_deviation(m, 0.0) ** 2)
        for t, m in zip(seen.taken, means, strict=True)
    ]
    score = sum(np.sum(m**2, axis=0) / c for m, c in zip(means, chance, strict=True))
    count = sum(len(m) - 1 for m in means)
    chosen, _ = _outliers(np.asarray(score), math.sqrt(2.0 * count))
    if not chosen.any():
        return None
    series = [m[:, chosen] for m in means]
    sizes, gain = random_sizes(series, chance)
    words = {"when": "frame", "where": where, "distribution": distribution(series)}
    return _of_lines(seen, chosen, words, gain, sizes, count)


def _jumping(seen: Layers, where: str, axis: int) -> Estimate | None:
    """Lines that jump between two levels within a frame: bridges of their running sums."""
    along = axis + 1
    length = seen.window.shape[axis]
    score, count = np.zeros(1), 0
    for t in seen.taken:
        rest = t.temporal / np.float32(t.noise)
        sums = np.cumsum(rest - rest.mean(axis=along, keepdims=True), axis=along)
        score = score + np.sum(np.mean(sums**2 / length, axis=along, dtype=float), axis=0)
        count += len(rest) - 1
    score = score / (count + len(seen.taken))
    chosen, gain = _outliers(score, math.sqrt(BRIDGE_VARIANCE / count))
    if not chosen.any():
        return None
    words = {"when": "frame", "where": f"{where}_segments", "distribution": "two_level"}
    return _of_lines(seen, chosen, words, gain, _more_variance(seen, axis, chosen), count)


def _outliers(score: np.ndarray, least: float) -> tuple[np.ndarray, float]:
    """Lines of a score beyond chance, of a scatter of at least so much, and their sum of squares.

    None where half of them are or more: what most have is no defect.
    """
    middle = float(np.median(score))
    pulls = (score - middle) / max(least, robust_deviation(score, middle))
    chosen = pulls > CLEAR
    if chosen.mean() >= 0.5:
        chosen = np.zeros_like(chosen)
    return chosen, float(np.sum(pulls[chosen] ** 2))


def _more_variance(seen: Layers, axis: int, chosen: np.ndarray) -> Sizes:
    """Variance of chosen lines beyond that of the others at every point, DN^2."""
    values, errors = [], []
    for t in seen.taken:
        lines = t.line_variances(axis)
        scatter = lines[chosen].std() if chosen.sum() > 1 else robust_deviation(lines)
        values.append(float(lines[chosen].mean() - np.median(lines[~chosen])))
        errors.append(max(float(scatter) / math.sqrt(chosen.sum()), 1e-9))
    return Sizes(np.array(values), np.array(errors), squares=True)


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
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]))) + first
    # first and last line of each run of chosen ones, one pair after the other
    runs = tuple(float(n) - k % 2 for k, n in enumerate(edges))
    effect = CompositeEffect(share=share, lines=runs, **words)
    spread = math.sqrt(share * (1 - share) / chosen.size)
    price = (float(chosen.sum()) + 2.0) * math.log(chosen.size * count)
    return Estimate(effect, {"share": spread}, gain, price, sizes)


def row_before(seen: Layers) -> Iterator[Estimate]:
    """A share of the row before in every row: neighbours correlate along the columns alone.

    y_i = x_i + g x_(i-1) has the correlation g / (1 + g^2) at a lag of one row and none at two.
    Which of the two rows keeps the share of the other, the fixed hot pixels tell.
    """
    values, errors, gain, along = [], [], 0.0, 0.0
    for t in seen.taken:
        rest = t.temporal / np.float32(t.noise)
        rest = rest - rest.mean(axis=1, keepdims=True) - rest.mean(axis=2, keepdims=True)
        # the rounding of the codes comes after the share is taken, and is not shared
        power = max(float(np.mean(rest * rest)) - ROUNDING_VARIANCE / t.noise**2, 1e-9)
        one = float(np.mean(rest[:, 1:] * rest[:, :-1])) / power
        two = float(np.mean(rest[:, 2:] * rest[:, :-2])) / power
        side = float(np.mean(rest[:, :, 1:] * rest[:, :, :-1])) / power
        r = min(max(one - two, -0.49), 0.49)
        count = rest[0].size * (len(rest) - 1.0)
        share = 2.0 * r / (1.0 + math.sqrt(1.0 - 4.0 * r * r))
        values.append(share)
        # of two correlations by chance, and the slope of the share over the correlation
        errors.append(math.sqrt(2.0 / count) * (1.0 + share**2) ** 2 / (1.0 - share**2))
        gain += max(r, 0.0) ** 2 * count / 2.0
        along += (side - two) * count / 2.0 * r
    if along <= COLUMN_SHARE * gain and _falls_on_the_next(seen):
        effect = CompositeEffect(what="gain", where="row_before")
        price = 3.0 * math.log(seen.taken[0].frames.size)
        yield Estimate(effect, {}, gain, price, Sizes(np.array(values), np.array(errors)))


def _falls_on_the_next(seen: Layers) -> bool:
    """Whether rows behind hot pixels are brighter than those before, at the warmest point."""
    mean = seen.taken[int(np.argmax(seen.dark))].mean
    rest = mean - np.median(mean)
    hot = rest[1:-1] > STATED * robust(rest)
    return bool(np.sum((rest[2:] - rest[:-2])[hot]) > 0)
