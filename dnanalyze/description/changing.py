"""What stays in its place and changes from frame to frame: a spot, a share of the row before."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.description.found import Estimate, Sizes, random_sizes
from dnanalyze.description.layers import Layers
from dnanalyze.description.spots import standing
from dnanalyze.model.composite.effect import CompositeEffect
from dnanalyze.model.effects.quantization import ROUNDING_VARIANCE
from dnanalyze.robust import QUARTILES

# Variance within the two groups, above and below 0, over the whole: 0 of two levels without noise,
# 1 - 2 / pi = .36 of a normal distribution; the middle.
TWO_GROUPS = (1.0 - 2.0 / math.pi) / 2.0
COLUMN_SHARE = 0.25  # correlation along the rows over that along the columns: crosstalk has 1
AT_ONCE = 0.05  # frames, the time constant of what draws anew in every frame


def standing_spot(seen: Layers, coarse: list[np.ndarray], noise: list[float]) -> list[Estimate]:
    """A spot in its place that is there in some frames and not in others, or changes its height."""
    fitted = standing(seen, coarse, noise)
    if fitted is None:
        return []
    series = list(zip(fitted.heights, fitted.chance, strict=True))
    sizes, gain = random_sizes(fitted.heights, fitted.chance)
    count = sum(c.size for c in coarse)
    price = (4.0 + len(series)) * math.log(count)
    words: dict[str, object] = {
        "where": "blob", "centre_y": fitted.centre[0], "centre_x": fitted.centre[1],
        "radius": min(max(fitted.radius, 0.3), 1e6),
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
            Estimate(effect, fitted.errors, gain, price, Sizes(np.array(values), np.array(errors)))
        ]
    effect = CompositeEffect(when="persisting", tau=AT_ONCE, **words)  # type: ignore[arg-type]
    return [Estimate(effect, fitted.errors, gain, price, sizes)]


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
    hot = rest[1:-1] > 3.0 * (high - low) / QUARTILES
    return bool(np.sum((rest[2:] - rest[:-2])[hot]) > 0)
