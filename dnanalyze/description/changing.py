"""What stays in its place and changes from frame to frame: a spot, lines, a share of a row."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.description.found import Estimate, Sizes
from dnanalyze.description.layers import Layers
from dnanalyze.description.random_size import random_size
from dnanalyze.description.spots import standing
from dnanalyze.description.variance_lines import groups
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.robust import robust_deviation

LINE_ERRORS = 5.0  # standard errors by which a line stands out
# Variance within the two groups, above and below 0, over the whole: 0 of two levels without noise,
# 1 - 2 / pi = .36 of a normal distribution; the middle.
TWO_GROUPS = 0.18
COLUMN_SHARE = 0.25  # correlation along the rows over that along the columns: crosstalk has 1
ROUNDING = 1.0 / 12.0  # DN^2
AT_ONCE = 0.05  # frames, the time constant of what draws anew in every frame


def standing_spot(seen: Layers, coarse: list[np.ndarray], noise: list[float]) -> list[Estimate]:
    """A spot in its place that is there in some frames and not in others, or changes its height."""
    told = standing(seen, coarse, noise)
    if told is None:
        return []
    series = list(zip(told.heights, told.chance, strict=True))
    frames = np.array([len(s) for s, _ in series])
    gain = sum(random_size(s, c)[2] * (len(s) - 1.0) / len(s) for s, c in series)
    count = sum(c.size for c in coarse)
    price = (4.0 + len(series)) * math.log(count)
    words: dict[str, object] = {
        "where": "blob", "centre_y": told.centre[0], "centre_x": told.centre[1],
        "radius": min(max(told.radius, 0.3), 1e6),
    }  # fmt: skip
    within = sum(float(np.sum((g - g.mean()) ** 2))
                 for s, _ in series for g in (s[s > 0], s[s <= 0]) if g.size)  # fmt: skip
    whole = sum(float(np.sum(s**2)) for s, _ in series)
    # what chance adds within the groups is no sign of a third level
    by_chance = sum((len(s) - 2.0) * c for s, c in series)
    if within - by_chance < TWO_GROUPS * max(whole - by_chance, 1e-300):
        values, errors, changes, steps = [], [], 0, 0
        for s, c in series:
            on = s > 0
            shown = float(np.sum(s**2)) > 9.0 * len(s) * c and 0 < on.sum() < on.size
            back = math.sqrt((len(s) - 1.0) / len(s))  # frames are scaled to a frame's variance
            values.append(float(s[on].mean() - s[~on].mean()) * back if shown else 0.0)
            inverse = 1.0 / max(on.sum(), 1) + 1.0 / max(on.size - on.sum(), 1)
            errors.append(math.sqrt(c * inverse) if shown else 1e6)
            changes += int(np.sum(on[1:] != on[:-1])) if shown else 0
            steps += len(s) - 1 if shown else 0
        # a state that draws anew with probability 1 - rho changes with (1 - rho) / 2
        rho = 1.0 - 2.0 * changes / max(steps, 1)
        tau = -1.0 / math.log(rho) if rho > 2.0 / math.sqrt(max(steps, 1)) and rho < 1 else AT_ONCE
        effect = CompositeEffect(when="switching", distribution="on_off", tau=tau, **words)  # type: ignore[arg-type]
        return [
            Estimate(effect, told.errors, gain, price, Sizes(np.array(values), np.array(errors)))
        ]
    found = [random_size(s, c) for s, c in series]
    sizes = Sizes(
        np.array([f[0] for f in found]),
        np.array([f[1] for f in found]) * np.sqrt(frames / (frames - 1.0)),
        squares=True,
    )
    effect = CompositeEffect(when="persisting", tau=AT_ONCE, **words)  # type: ignore[arg-type]
    return [Estimate(effect, told.errors, gain, price, sizes)]


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
        chosen = score > middle + LINE_ERRORS * error
        share = float(chosen.mean())
        if not 0 < share < 0.5:
            continue
        told = [random_size(m[:, chosen], c) for m, c in zip(means, chance, strict=True)]
        frames = np.array([len(m) for m in means])
        gain = float(np.sum([f[2] for f in told] * (frames - 1.0) / frames))
        sizes = Sizes(
            np.array([f[0] for f in told]),
            np.array([f[1] for f in told]) * np.sqrt(frames / (frames - 1.0)),
            squares=True,
        )
        values = np.concatenate([m[:, chosen].ravel() for m in means])
        first = seen.window.top if where == "row" else seen.window.left
        effect = CompositeEffect(
            when="frame", where=where, share=share, lines=groups(chosen, first),
            distribution="two_level" if _two_levels(values, frames) else "normal",
        )  # fmt: skip
        spread = math.sqrt(share * (1 - share) / chosen.size)
        price = (float(chosen.sum()) + 2.0) * math.log(chosen.size * count)
        found.append(Estimate(effect, {"share": spread}, gain, price, sizes))
    return found


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


def row_before(seen: Layers) -> list[Estimate]:
    """A share of the row before in every row: neighbours correlate along the columns alone.

    y_i = x_i + g x_(i-1) has the correlation g / (1 + g^2) at a lag of one row and none at two.
    Which of the two rows keeps the share of the other, the fixed hot pixels tell.
    """
    values, errors, gain, along = [], [], 0.0, 0.0
    for t in seen.taken:
        rest = t.temporal / np.float32(t.noise)
        rest = rest - rest.mean(axis=1, keepdims=True) - rest.mean(axis=2, keepdims=True)
        # the rounding of the codes comes after the share is taken, and is not shared
        power = max(float(np.mean(rest * rest)) - ROUNDING / t.noise**2, 1e-9)
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
    if along > COLUMN_SHARE * gain or not _falls_on_the_next(seen):
        return []
    effect = CompositeEffect(what="gain", where="row_before")
    price = 3.0 * math.log(seen.taken[0].frames.size)
    return [Estimate(effect, {}, gain, price, Sizes(np.array(values), np.array(errors)))]


def _falls_on_the_next(seen: Layers) -> bool:
    """Whether rows behind hot pixels are brighter than those before, at the warmest point."""
    mean = seen.taken[int(np.argmax(seen.dark))].mean
    rest = mean - np.median(mean)
    low, high = np.percentile(rest, (25, 75))
    hot = rest[1:-1] > 3.0 * (high - low) / 1.349
    return bool(np.sum((rest[2:] - rest[:-2])[hot]) > 0)
