"""Numbers of hot, cold and dead pixels, of outliers in one frame, and the share that repeats."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy import special

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.estimators.uncertainty import (
    block_sums,
    clustered_variance,
    counts_below,
    mean_residuals,
    repeated_variance,
    share_residuals,
)
from dnanalyze.analyzers.families.family import FamilyResult
from dnanalyze.analyzers.statistics import Scale, StatisticInfo, Value

HOT = (5, 8, 16, 32, 64, 128)
COLD = (5, 8)
TRANSIENT = 8.0  # robust temporal sigmas
_DEAD_CHANCE = 1e-4  # that so many of the pixels at a code never change
DEAD_NOISE = 0.3  # DN of temporal noise from which a pixel without any is dead
LEAST_ERROR = math.sqrt(
    2.0
)  # error of pixels in clumps, which hold two at least, where there are none
MOST_LISTED = 1 << 16  # hot pixels
TAIL_SHARE = 0.001  # of the pixels, for the tail index
EXCEEDANCE = np.concatenate([-np.geomspace(16, 1, 9), np.geomspace(1, 256, 33)])  # robust sigmas

INFOS = (
    *(
        StatisticInfo(
            f"hot_count_{k}", "tails", "pixels", f"pixels above {k} robust sigma", Scale.ROOT,
            high=f"{{ratio}} times as many pixels as in the model lie more than {k} robust sigma "
            "above the median",
            low=f"only {{ratio}} of the model's number of pixels lie more than {k} robust sigma "
            "above the median",
        )
        for k in HOT
    ),
    *(
        StatisticInfo(
            f"cold_count_{k}", "tails", "pixels", f"pixels below {k} robust sigma", Scale.ROOT,
            high=f"{{ratio}} times as many pixels as in the model lie more than {k} robust sigma "
            "below the median",
            low=f"only {{ratio}} of the model's number of pixels lie more than {k} robust sigma "
            "below the median",
        )
        for k in COLD
    ),
    StatisticInfo(
        "transient_high", "tails", "pixels", "pixels bright in one frame only", Scale.ROOT,
        high="{ratio} times as many pixels as in the model are bright in a single frame",
        low="only {ratio} of the model's number of pixels are bright in a single frame",
    ),
    StatisticInfo(
        "transient_low", "tails", "pixels", "pixels dark in one frame only", Scale.ROOT,
        high="{ratio} times as many pixels as in the model are dark in a single frame",
        low="only {ratio} of the model's number of pixels are dark in a single frame",
    ),
    StatisticInfo(
        "transient_adjacent", "tails", "pixels", "adjacent pixels bright in one frame", Scale.ROOT,
        high="pixels that are bright in a single frame form tracks and clusters more than in the "
        "model",
        low="pixels that are bright in a single frame form fewer tracks than in the model",
    ),
    StatisticInfo(
        "hot_pairs", "tails", "pixels", "hot pixels with a hot neighbour", Scale.ROOT,
        high="hot pixels have hot neighbours {ratio} times as often as in the model",
        low="hot pixels have hot neighbours only {ratio} times as often as in the model",
    ),
    StatisticInfo(
        "hot_repeat", "tails", "1", "share of hot pixels that repeat in the next frame",
        high="hot pixels stay from frame to frame more than in the model",
        low="hot pixels change from frame to frame more than in the model",
    ),
    StatisticInfo(
        "dead_count", "tails", "pixels", "pixels that never change", Scale.ROOT,
        high="pixels that give the same code in every frame are {ratio} times the model's number",
        low="pixels that give the same code in every frame are only {ratio} of the model's number",
    ),
    StatisticInfo(
        "hot_density_frame", "tails", "ppm", "hot pixels > 5 sigma, single frame", compared=False
    ),
    StatisticInfo(
        "hot_density_pattern", "tails", "ppm", "hot pixels > 5 sigma, mean frame", compared=False
    ),
    StatisticInfo(
        "frame_above_5", "tails", "1", "share of pixels > 5 sigma, single frame", compared=False
    ),
    StatisticInfo(
        "tail_index", "tails", "1", "Hill's tail index of the mean frame", compared=False
    ),
)  # fmt: skip


def finish(acc: Accumulated) -> FamilyResult:
    """Counts in the tails of the accumulated frames."""
    out = FamilyResult()
    centre, sigma = acc.pattern_centre, lower_sigma(acc)
    _counts(acc, centre, sigma, out)
    hot = acc.pattern > np.float32(centre + 8 * sigma)
    out.values["hot_pairs"] = _in_clumps(links(hot), acc.plan.errors)
    _exceedance(acc, centre, sigma, out)
    if acc.plan.errors:
        _densities(acc, out)
        out.curves["hot_pixels"] = _hot_pixels(acc)
        out.curves["hot_levels"] = acc.pattern.ravel()[out.curves["hot_pixels"]]
        _tail_index(acc, out)
    if acc.frames == 1:
        for name in ("transient_high", "transient_low", "transient_adjacent", "hot_repeat"):
            out.missing[name] = "needs at least two frames"
        out.missing["dead_count"] = "needs at least three frames"
        return out
    _repeat(acc, out)
    _transients(acc, out)
    _dead(acc, out)
    return out


def lower_sigma(acc: Accumulated) -> float:
    """Robust sigma of F from its lower half, which hot pixels do not widen, DN."""
    low, middle = acc.pattern_ordered.quantile(np.array([0.25, 0.5]))
    return max(float(middle - low) / 0.6745, 1e-3 * acc.pattern_sigma)


@dataclass(frozen=True)
class Links:
    """Pixels that are set, and the pairs of them that are neighbours: numbers of the one and other.

    Each pair is there once.
    """

    pixels: int
    one: np.ndarray
    other: np.ndarray

    def with_neighbour(self) -> int:
        """Pixels that are in a pair."""
        linked = np.zeros(self.pixels, bool)
        linked[self.one] = linked[self.other] = True
        return int(np.count_nonzero(linked))

    def clump_sizes(self) -> np.ndarray:
        """Pixels of the clump that each pixel is in, itself included."""
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        n = self.pixels
        if not n:
            return np.zeros(0, int)
        linked = coo_array((np.ones(self.one.size, bool), (self.one, self.other)), (n, n))
        clump = connected_components(linked, directed=False)[1]
        return np.asarray(np.bincount(clump)[clump])


def links(mask: np.ndarray, kind: np.ndarray | None = None) -> Links:
    """Set pixels of ``mask`` among whose 8 neighbours another is, of the same ``kind`` if given."""
    where = np.flatnonzero(mask)
    n, columns = where.size, mask.shape[1]
    kinds = np.zeros(n) if kind is None else kind.ravel()[where]
    keys = where + 2 * (where // columns)  # lines that are apart: no end has a neighbour there
    to = keys + np.array([1, columns + 1, columns + 2, columns + 3])[:, None]
    at = np.minimum(np.searchsorted(keys, to), n - 1)
    _, one = pair = np.nonzero((keys[at] == to) & (kinds[at] == kinds))
    return Links(n, one, at[pair])


def _in_clumps(found: Links, errors: bool) -> Value:
    """Pixels with a neighbour: clumps are Poisson, and a clump's pixels come together."""
    count = found.with_neighbour()
    if not (count and errors):
        return Value(float(count), LEAST_ERROR)
    sizes = found.clump_sizes()
    return Value(float(count), math.sqrt(float(sizes[sizes > 1].mean())))


def _counts(acc: Accumulated, centre: float, sigma: float, out: FamilyResult) -> None:
    """Hot and cold counts; their errors hold that of the threshold itself."""
    pattern, ordered, pixels = acc.pattern, acc.pattern_ordered, acc.plan.pixels
    steps = np.array([-8.0, -5.0, *map(float, HOT)])
    limits = centre + steps * sigma
    if not acc.plan.errors:
        below = np.searchsorted(ordered.sorted, limits.astype(np.float32))
        for step, n in zip(steps, below.tolist(), strict=True):
            out.values[_count_name(step)] = Value(float(n if step < 0 else pixels - n), 1.0)
        return
    quartiles = ordered.quantile(np.array([0.25, 0.5]))
    thresholds = np.concatenate([limits[:2], quartiles, limits[2:]])
    below = counts_below(acc.plan, pattern, thresholds)
    residual = share_residuals(acc.plan, below) * pixels
    bins = max(0.2 * sigma, acc.pattern_step)
    density = (ordered.share_below(quartiles + bins) - ordered.share_below(quartiles - bins)) / (
        2 * bins
    )
    low, middle = (-residual[..., 2 + j] / max(density[j], 1e-12) / pixels for j in (0, 1))
    for k, step in enumerate(steps):
        column = k if k < 2 else k + 2
        count = float(below[..., column].sum())
        count = count if k < 2 else pixels - count
        h = max(0.1 * abs(step) * sigma, acc.pattern_step)
        crowd = abs(float(np.diff(ordered.count_above(limits[k] + np.array([-h, h])))[0])) / (2 * h)
        move = middle + step * (middle - low) / 0.6745
        total = residual[..., column] - move * crowd
        variance = max(float(clustered_variance(total)), count + 0.375)
        out.values[_count_name(step)] = Value(count, math.sqrt(variance / (count + 0.375)))


def _count_name(step: float) -> str:
    return f"cold_count_{-step:g}" if step < 0 else f"hot_count_{step:g}"


def _densities(acc: Accumulated, out: FamilyResult) -> None:
    frame = acc.values
    limit = float(frame.quantile(0.5)) + 5 * frame.robust_sigma()
    share = 1.0 - float(frame.share_below(limit))
    se = math.sqrt(share * acc.plan.pixels + 1) / acc.plan.pixels
    out.values["frame_above_5"] = Value(share, se)
    out.values["hot_density_frame"] = Value(1e6 * share, 1e6 * se)
    if acc.frames > 1:
        limit = acc.pattern_centre + 5 * acc.pattern_sigma
        above = float(acc.pattern_ordered.count_above(limit))
        scale = 1e6 / acc.plan.pixels
        out.values["hot_density_pattern"] = Value(above * scale, math.sqrt(above + 1) * scale)
    else:
        out.missing["hot_density_pattern"] = "one frame does not separate DSNU from temporal noise"


def _hot_pixels(acc: Accumulated) -> np.ndarray:
    """Flat index of the pixels of F above 5 robust sigma, or of the brightest ones."""
    ordered = acc.pattern_ordered
    limit = acc.pattern_centre + 5 * acc.pattern_sigma
    if int(ordered.count_above(limit)) > MOST_LISTED:
        limit = float(ordered.sorted[-MOST_LISTED])
    return np.flatnonzero(acc.pattern > np.float32(limit))


def _exceedance(acc: Accumulated, centre: float, sigma: float, out: FamilyResult) -> None:
    """Share of F above and below k robust sigma, k from -16 to 256."""
    ordered = acc.pattern_ordered
    above = ordered.count_above(centre + EXCEEDANCE * sigma)
    out.curves["exceedance_k"] = EXCEEDANCE.copy()
    out.curves["exceedance_n"] = np.where(EXCEEDANCE > 0, above, ordered.sorted.size - above)


def _tail_index(acc: Accumulated, out: FamilyResult) -> None:
    """Hill's estimate of alpha in P(x > t) ~ t^-alpha, t from the median.

    Ann. Stat. 3, 1163 (1975).
    """
    count = int(TAIL_SHARE * acc.plan.pixels)
    tail = acc.pattern_ordered.sorted[-count - 1 :].astype(float) - acc.pattern_centre
    if count < 20 or tail[0] <= 0 or tail[-1] <= tail[0]:
        out.missing["tail_index"] = "fewer than 20 pixels in the tail"
        return
    index = count / float(np.sum(np.log(tail[1:] / tail[0])))
    out.values["tail_index"] = Value(index, index / math.sqrt(count))


def _repeat(acc: Accumulated, out: FamilyResult) -> None:
    scalars = acc.maps.scalars
    before, both = float(scalars[:-1, 3].sum()), float(scalars[1:, 4].sum())
    if before == 0:
        out.missing["hot_repeat"] = "no pixel lies above 5 robust sigma"
        return
    pixels = before / (acc.frames - 1)
    share = both / before
    if not acc.plan.errors:
        out.values["hot_repeat"] = Value(share, 0.5 / (pixels + 2))
        return
    pairs = [acc.maps.head] if acc.frames == 2 else [acc.maps.head, acc.maps.tail]
    limits, part = (acc.maps.hot_limit + acc.maps.shifts).astype(np.float32), np.float32(share)

    def influence(n: int, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        hot = first > limits[n]
        return (hot & (second > limits[n + 1])) - part * hot

    numbers = [0] if acc.frames == 2 else [0, acc.frames - 2]
    sides = [
        mean_residuals(acc.plan, block_sums(acc.plan, partial(influence, n), *pair))
        for n, pair in zip(numbers, pairs, strict=True)
    ]
    se = math.sqrt(float(repeated_variance(sides, acc.frames - 1))) * acc.plan.pixels / pixels
    out.values["hot_repeat"] = Value(share, max(se, 0.5 / (pixels + 2)))


def _transients(acc: Accumulated, out: FamilyResult) -> None:
    """Rise and fall against the mean of the pixel's other frames; its other extreme is left out
    of that mean where three frames allow, so that a flash does not make the rest look dark."""
    k, maps = acc.frames, acc.maps
    limit = np.float32(TRANSIENT * acc.difference_sigma * math.sqrt(1 + 1 / max(k - 2, 1)))
    limits = (limit, 0.9 * limit) if acc.plan.errors else (limit,)
    bright = np.empty(acc.plan.shape, bool)
    rises, falls = np.zeros(len(limits)), np.zeros(len(limits))
    for bands in acc.plan.row_parts:
        rows = acc.plan.rows_of(bands)
        high, low = maps.high[rows], maps.low[rows]
        if k > 2:
            others = (maps.mean[rows] * np.float32(k) - high - low) / np.float32(k - 2)
            rise, fall = high - others, others - low
        else:
            rise = fall = high - low
        for counts, change in ((rises, rise), (falls, fall)):
            counts += [np.count_nonzero(change > cut) for cut in limits]
        np.greater(rise, limit, out=bright[rows])
    found = links(bright, maps.high_at)
    errors = {"transient_high": 0.0, "transient_low": 0.0}
    if acc.plan.errors:
        sizes = found.clump_sizes()
        pixels = np.bincount(sizes, minlength=1)
        out.curves["transient_clumps"] = pixels / np.maximum(np.arange(pixels.size), 1)
        errors["transient_high"] = _transient_error(acc, rises, limit, sizes)
        errors["transient_low"] = _transient_error(acc, falls, limit, np.ones(1))
    for (name, error), counts in zip(errors.items(), (rises, falls), strict=True):
        out.values[name] = Value(float(counts[0]), error)
    out.values["transient_adjacent"] = _in_clumps(found, acc.plan.errors)


def _transient_error(
    acc: Accumulated, counts: np.ndarray, limit: np.float32, sizes: np.ndarray
) -> float:
    """Error of the number of pixels above the limit, from those above it and above .9 of it.

    It is that of the clumps, of these ``sizes``, in which they come, and of drifting frames, which
    move all pixels.
    """
    count, inside = counts.tolist()
    slope = (inside - count) / 0.1  # per relative change of the limit
    relative = acc.drift_error(acc.difference_sigma**2) / 2
    relative = math.hypot(relative, math.sqrt(acc.level_variance) / float(limit))
    together = float(sizes.mean()) if sizes.size else 1.0
    return math.sqrt(together + (slope * relative) ** 2 / (count + 0.375))


def _dead(acc: Accumulated, out: FamilyResult) -> None:
    noise = acc.temporal_variance
    assert noise is not None
    if acc.frames < 3:
        out.missing["dead_count"] = "needs at least three frames"
    elif acc.difference_sigma <= DEAD_NOISE:
        out.missing["dead_count"] = f"the temporal noise is below {DEAD_NOISE:g} DN"
    else:
        count = float(np.count_nonzero(noise == 0))
        # one code in all of K frames: as rare as noise, and what moves them, to the power K - 1
        drifting = math.sqrt(count) * (acc.frames - 1) / 2 * acc.drift_error(acc.temporal_mean)
        out.values["dead_count"] = Value(count, math.hypot(1.0, drifting))
        if acc.plan.errors:
            out.curves["dead_codes"] = _dead_codes(acc, noise == 0)


def _dead_codes(acc: Accumulated, dead: np.ndarray) -> np.ndarray:
    """Codes at which more pixels never change than by chance, those of most of them first.

    Chance is the share of such pixels within 2 sigma of the level, of which none is told.
    """
    first = acc.end_frames[0]
    body = np.abs(first - np.float32(acc.plan.centre)) < 2.0 * acc.plan.sigma
    chance = float(dead[body].mean()) if body.any() else 0.0
    codes, counts = np.unique(first[dead & ~body], return_counts=True)
    if not codes.size:
        return codes
    at = np.minimum(np.searchsorted(codes, first.ravel()), codes.size - 1)
    alike = np.bincount(at[codes[at] == first.ravel()], minlength=codes.size)
    by_chance = special.bdtrc(counts - 1.0, alike.astype(np.int64), chance)
    told = np.flatnonzero(by_chance < _DEAD_CHANCE)
    return np.asarray(codes[told[np.argsort(-counts[told], kind="stable")]])
