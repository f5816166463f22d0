"""Changes from frame to frame: drift, correlation in time, RTS pixels, noise by pixel."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.estimators.groups import groups
from dnanalyze.analyzers.estimators.photon_transfer import transfer_points
from dnanalyze.analyzers.estimators.quantiles import Ordered, Tied
from dnanalyze.analyzers.estimators.uncertainty import (
    QuantileErrors,
    block_sums,
    map_sums,
    mean_error,
)
from dnanalyze.analyzers.families.family import FamilyResult
from dnanalyze.analyzers.plan import CLIP
from dnanalyze.analyzers.statistics import Scale, StatisticInfo, Value

VARIANCE_LEVELS = ("0.5", "0.9", "0.99", "0.999")
GROUPS = {  # of pixels by their value in the mean frame: quantiles, and in words
    "50": (0.0, 0.5, "darker half of the pixels"),
    "90": (0.9, 0.99, "pixels from the 90 to the 99 % quantile of the mean frame"),
    "99": (0.99, 0.999, "pixels from the 99 to the 99.9 % quantile of the mean frame"),
    "999": (0.999, 1.0, "brightest 0.1 % of the pixels"),
}
CUTS = np.array([0.5, 0.9, 0.99, 0.999])
FEWEST = 8.0  # pixels in a group for it to be stated
END_SCATTERS = 3.0  # ends of r1, times its scatter 1 / sqrt(frames)
TIED_FRAMES = 8  # up to which variances of codes take few values

INFOS = (
    StatisticInfo(
        "drift", "time", "DN", "standard deviation of the frame means", Scale.LOG,
        high="the mean of the frames varies {ratio} times as much as in the model",
        low="the mean of the frames varies only {ratio} times as much as in the model",
    ),
    StatisticInfo(
        "temporal_r1", "time", "1", "temporal correlation of a pixel, successive frames",
        high="the temporal noise of successive frames is correlated: a temporal filter, or slow "
        "noise",
        low="the temporal noise of successive frames is anticorrelated",
    ),
    *(
        StatisticInfo(
            f"temporal_variance_q{level}", "time", "1",
            f"{float(level):g} quantile of the pixels' temporal variance over its mean", Scale.LOG,
            high=f"the noisiest {100 * (1 - float(level)):.3g} % of the pixels are {{ratio}} times "
            "as noisy, in variance, as the model's",
            low=f"the noisiest {100 * (1 - float(level)):.3g} % of the pixels are only {{ratio}} "
            "times as noisy, in variance, as the model's",
        )
        for level in VARIANCE_LEVELS
    ),
    StatisticInfo(
        "blink_repeat", "time", "1", "correlation of a pixel's temporal variance in two halves",
        high="the same pixels are noisy in all parts of the series, as RTS pixels are",
        low="noisy pixels are less often noisy in all parts of the series than in the model",
    ),
    *(
        StatisticInfo(
            f"noise_at_{name}", "time", "DN^2",
            f"temporal variance, {100 * low:g} to {100 * high:g} % quantile of the mean frame",
            Scale.LOG,
            high=f"in the {part} the temporal variance is {{ratio}} times the model's",
            low=f"in the {part} the temporal variance is only {{ratio}} times the model's",
        )
        for name, (low, high, part) in GROUPS.items()
    ),
    StatisticInfo(
        "pattern_correlation", "time", "1", "correlation of successive frames",
        high="the fixed pattern is a larger share of one frame's variance than in the model",
        low="the fixed pattern is a smaller share of one frame's variance than in the model",
    ),
    StatisticInfo("drift_trend", "time", "DN/frame", "slope of the frame means", compared=False),
    StatisticInfo(
        "blinking_count", "time", "pixels", "pixels with repeated temporal outliers", compared=False
    ),
)  # fmt: skip


def finish(acc: Accumulated) -> FamilyResult:
    """Statistics over the order of the frames."""
    out = FamilyResult()
    out.curves["frame_means"] = acc.frame_means + acc.plan.centre
    if acc.frames < 2:
        reason = "one frame does not separate DSNU from temporal noise"
        out.missing.update(dict.fromkeys((i.name for i in INFOS), reason))
        return out
    _drift(acc, out)
    _pattern_correlation(acc, out)
    _variances(acc, out)
    if acc.frames < 4:
        reason = "needs at least four frames"
        out.missing.update(dict.fromkeys(("temporal_r1", "blink_repeat", "blinking_count"), reason))
        return out
    _lag_one(acc, out)
    _blinking(acc, out)
    return out


@cache
def log_spread_error(degrees: int) -> float:
    """Standard error of the log of a Gaussian sample's standard deviation; degrees of freedom."""
    from scipy.special import polygamma

    return 0.5 * math.sqrt(float(polygamma(1, degrees / 2)))


def _drift(acc: Accumulated, out: FamilyResult) -> None:
    k, means = acc.frames, acc.frame_means
    sd = math.sqrt(acc.drift_variance)
    least = 1e-6 * acc.plan.sigma
    out.values["drift"] = Value(max(sd, least), log_spread_error(k - 1))
    if k < 3:
        out.missing["drift_trend"] = "needs at least three frames"
        return
    n = np.arange(k) - (k - 1) / 2
    slope = float(n @ means) / float(n @ n)
    rest = means - means.mean() - slope * n
    error = math.sqrt(float(rest @ rest) / (k - 2) / float(n @ n))
    out.values["drift_trend"] = Value(slope, max(error, least / k))


def _pattern_correlation(acc: Accumulated, out: FamilyResult) -> None:
    """Pooled over the pairs of successive frames, each with its own mean taken off."""
    scalars, n = acc.maps.scalars, acc.plan.pixels
    mean, square = scalars[:, 0] / n, scalars[:, 1] / n
    variance = np.maximum(square - mean**2, 0.0)
    cross = scalars[1:, 2] / n - mean[1:] * mean[:-1]
    scale = float(np.sum(np.sqrt(variance[1:] * variance[:-1])))
    if scale <= 0:
        out.missing["pattern_correlation"] = "the frames are constant"
        return
    r = float(cross.sum()) / scale
    error = 0.0
    if acc.plan.errors:
        reach = np.float32(CLIP * acc.plan.sigma)

        def standardised(rows: np.ndarray, n: int) -> np.ndarray:
            centre = np.float32(acc.plan.centre + acc.maps.shifts[n])
            z = np.clip(rows - centre, -reach, reach)
            z -= np.float32(mean[n])
            z *= np.float32(1 / max(math.sqrt(variance[n]), 1e-30))
            return z

        def influence(first: np.ndarray, last: np.ndarray) -> np.ndarray:
            return correlation_influence(standardised(first, 0), standardised(last, -1), r)

        error = mean_error(acc.plan, block_sums(acc.plan, influence, *acc.end_frames))
    out.values["pattern_correlation"] = Value(r, max(error, 1e-6))


def correlation_influence(a: np.ndarray, b: np.ndarray, r: float) -> np.ndarray:
    """What each pair of standardised values, float32, adds to their correlation r."""
    return a * b - np.float32(r / 2) * (a * a + b * b)


def _variances(acc: Accumulated, out: FamilyResult) -> None:
    variance, mean = acc.temporal_variance, acc.temporal_mean
    assert variance is not None
    names = [f"temporal_variance_q{level}" for level in VARIANCE_LEVELS]
    if mean <= 0:
        reason = "the frames are identical"
        absent = names + [f"noise_at_{name}" for name in GROUPS]
        out.missing.update(dict.fromkeys(absent, reason))
        return
    p = np.array([float(level) for level in VARIANCE_LEVELS])
    tied = acc.plan.integer and acc.frames <= TIED_FRAMES
    law = Tied(variance) if tied else Ordered(variance)
    errors = QuantileErrors(acc.plan, (variance,), law, p)
    relative = errors.over_mean(variance)
    drift = acc.drift_error(mean) / 2  # half: it widens the law, too
    for k, name in enumerate(names):
        value = float(errors.values[k]) / mean
        if (1 - p[k]) * acc.plan.pixels < FEWEST:
            out.missing[name] = f"fewer than {FEWEST:g} pixels are expected beyond it"
        elif value <= 0:
            out.missing[name] = "most pixels do not change between the frames"
        else:
            out.values[name] = Value(
                value, max(math.hypot(relative[k], drift * (1 - value) / value), 1e-3)
            )
    _noise_at(acc, variance, out)
    if acc.plan.errors:
        out.curves["photon_transfer"] = transfer_points(
            acc.pattern, variance, acc.pattern_centre, acc.pattern_sigma, acc.frames,
            acc.temporal_mean - acc.still_variance,
        )  # fmt: skip


def _noise_at(acc: Accumulated, variance: np.ndarray, out: FamilyResult) -> None:
    by_level = groups(acc.plan, acc.pattern, acc.pattern_ordered, variance, CUTS)
    for name, group in zip(GROUPS, (0, 2, 3, 4), strict=True):
        full = f"noise_at_{name}"
        if by_level.pixels(group) < FEWEST:
            out.missing[full] = f"fewer than {FEWEST:g} pixels are that bright"
            continue
        mean = by_level.mean(group)
        if mean <= 0:
            out.missing[full] = "these pixels do not change between the frames"
        else:
            se = by_level.relative_error(group) if acc.plan.errors else 0.0
            out.values[full] = Value(mean, max(math.hypot(se, acc.drift_error(mean)), 1e-3))


def _lag_one(acc: Accumulated, out: FamilyResult) -> None:
    variance = acc.temporal_variance
    assert variance is not None
    noisy = variance > 0
    if np.count_nonzero(noisy) < 0.5 * noisy.size:
        out.missing["temporal_r1"] = "most pixels do not change between the frames"
        return
    k = acc.frames
    with np.errstate(divide="ignore", invalid="ignore"):
        r1 = acc.maps.lag_one / (variance * np.float32(k - 1))
    r1[~noisy] = -1.0 / k
    # A mean within fixed ends: codes give few different values, and a median jumps between them.
    reach = END_SCATTERS / math.sqrt(k)
    np.clip(r1, -1 / k - reach, -1 / k + reach, out=r1)
    mean = float(np.mean(r1, dtype=np.float64))
    drift = acc.drift_error(acc.temporal_mean) / math.sqrt(2)  # whole frames are one series
    se = mean_error(acc.plan, map_sums(acc.plan, r1)) if acc.plan.errors else 0.0
    out.values["temporal_r1"] = Value(mean + 1 / k, max(math.hypot(se, drift), 5e-4))


def _blinking(acc: Accumulated, out: FamilyResult) -> None:
    """Correlation over pixels of squared differences of two disjoint sets of frame pairs."""
    from dnanalyze.analyzers.kernels import pixel_loops

    a, b = acc.maps.pair_squares
    if acc.plan.errors:
        scale = np.float32(2 * acc.difference_sigma**2)
        pairs = [len(range(start, acc.frames, 4)) for start in (1, 3)]
        far = [x > 10 * scale * n for x, n in zip((a, b), pairs, strict=True)]
        out.values["blinking_count"] = Value(float(np.count_nonzero(far[0] & far[1])), 1.0)
    sums = np.array(pixel_loops.products(a.ravel(), b.ravel())) / acc.plan.pixels
    mean, sd = sums[:2], np.sqrt(np.maximum(sums[2:4] - sums[:2] ** 2, 0.0))
    if sd.min() <= 1e-6 * mean.max():
        out.missing["blink_repeat"] = "the frames are identical"
        return
    r = float((sums[4] - mean[0] * mean[1]) / (sd[0] * sd[1]))
    error = 0.0
    if acc.plan.errors:
        shift, rate = mean.astype(np.float32), (1 / sd).astype(np.float32)

        def influence(one: np.ndarray, other: np.ndarray) -> np.ndarray:
            z = (one - shift[0]) * rate[0], (other - shift[1]) * rate[1]
            return correlation_influence(*z, r)

        error = mean_error(acc.plan, block_sums(acc.plan, influence, a, b))
    out.values["blink_repeat"] = Value(r, max(error, 1e-4))
