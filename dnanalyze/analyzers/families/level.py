"""Mean and standard deviations of dark frames, and the split of the DSNU as in EMVA 1288."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.estimators.pictures import pictures
from dnanalyze.analyzers.estimators.uncertainty import (
    QuantileErrors,
    block_sums,
    map_sums,
    mean_error,
)
from dnanalyze.analyzers.families.family import FamilyResult
from dnanalyze.analyzers.plan import CLIP
from dnanalyze.analyzers.statistics import Scale, StatisticInfo, Value

RESOLUTION = 0.005  # DN, below which quantiles of codes are not told apart

INFOS = (
    StatisticInfo(
        "mean", "level", "DN", "mean dark signal",
        high="the mean dark signal is {difference} above the model's",
        low="the mean dark signal is {difference} below the model's",
    ),
    StatisticInfo(
        "median", "level", "DN", "median dark signal",
        high="the median dark signal is {difference} above the model's",
        low="the median dark signal is {difference} below the model's",
    ),
    StatisticInfo(
        "temporal_noise", "level", "DN", "temporal dark noise", Scale.LOG,
        high="the temporal dark noise is {ratio} times the model's",
        low="the temporal dark noise is only {ratio} of the model's",
    ),
    StatisticInfo(
        "temporal_noise_core", "level", "DN", "temporal dark noise, robust", Scale.LOG,
        high="the robust temporal dark noise is {ratio} times the model's",
        low="the robust temporal dark noise is only {ratio} of the model's",
    ),
    StatisticInfo(
        "pattern_noise", "level", "DN", "standard deviation of the mean frame", Scale.LOG,
        high="the standard deviation of the mean frame is {ratio} times the model's",
        low="the standard deviation of the mean frame is only {ratio} of the model's",
    ),
    StatisticInfo(
        "pattern_noise_core", "level", "DN", "mean frame, central 68 %", Scale.LOG,
        high="the robust standard deviation of the mean frame is {ratio} times the model's",
        low="the robust standard deviation of the mean frame is only {ratio} of the model's",
    ),
    StatisticInfo(
        "frame_noise_core", "level", "DN", "single frame, central 68 %", Scale.LOG,
        high="the robust standard deviation of one frame is {ratio} times the model's",
        low="the robust standard deviation of one frame is only {ratio} of the model's",
    ),
    StatisticInfo("dsnu_1288", "level", "DN", "EMVA 1288 DSNU", compared=False),
    StatisticInfo("dsnu_1288_row", "level", "DN", "EMVA 1288 DSNU, rows", compared=False),
    StatisticInfo("dsnu_1288_col", "level", "DN", "EMVA 1288 DSNU, columns", compared=False),
    StatisticInfo("dsnu_1288_pix", "level", "DN", "EMVA 1288 DSNU, pixels", compared=False),
    StatisticInfo("s2_temporal", "level", "DN^2", "EMVA 1288 temporal variance", compared=False),
)  # fmt: skip

CORE = np.array([0.16, 0.5, 0.84])
SPREAD = np.array([-0.5, 0.0, 0.5])
MIDDLE_AND_SPREAD = np.stack([[0.0, 1.0, 0.0], SPREAD], axis=1)


def finish(acc: Accumulated) -> FamilyResult:
    """Levels and spreads of the accumulated frames."""
    out = FamilyResult()
    _frames(acc, out.values)
    if acc.plan.errors and not acc.plan.families:
        out.curves.update(pictures(acc))
    if acc.frames < 2:
        reason = "one frame does not separate DSNU from temporal noise"
        absent = [i.name for i in INFOS if i.name not in out.values]
        out.missing.update(dict.fromkeys(absent, reason))
        return out
    _temporal(acc, out.values)
    _pattern(acc, out.values)
    if acc.plan.errors:
        out.values.update(emva_split(acc))
    return out


def floor(acc: Accumulated) -> float:
    """Smallest standard error of a quantile, DN."""
    return RESOLUTION if acc.plan.integer else 1e-6 * acc.plan.sigma


def _frames(acc: Accumulated, values: dict[str, Value]) -> None:
    drift = acc.level_variance
    sums = map_sums(acc.plan, acc.pattern)
    mean = float(sums.sum()) / acc.plan.pixels
    spatial = mean_error(acc.plan, sums)
    values["mean"] = Value(mean, max(math.sqrt(spatial**2 + drift), 0.1 * floor(acc)))
    errors = QuantileErrors(acc.plan, acc.end_frames, acc.values, CORE, acc.frames)
    middle, core = errors.of(MIDDLE_AND_SPREAD)
    level = max(math.sqrt(middle**2 + drift), floor(acc))
    values["median"] = Value(float(errors.values[1]), level)
    values["frame_noise_core"] = _log_core(float(errors.values @ SPREAD), core, acc, drift=True)


def _log_core(width: float, error: float, acc: Accumulated, drift: bool) -> Value:
    """A spread on the log scale; where whole frames move, its error has that part too."""
    width = max(width, floor(acc))
    relative = max(error, floor(acc) / 2) / width
    if drift:
        relative = math.hypot(relative, acc.drift_error(width**2) / 2)
    return Value(width, relative)


def _temporal(acc: Accumulated, values: dict[str, Value]) -> None:
    variance = acc.temporal_variance
    assert variance is not None
    mean = acc.temporal_mean
    least = floor(acc) ** 2
    error = mean_error(acc.plan, map_sums(acc.plan, variance)) if acc.plan.errors else 0.0
    if mean > 0:
        relative = error / mean
        se = max(math.hypot(relative, acc.drift_error(mean)) / 2, least / mean)
        values["temporal_noise"] = Value(math.sqrt(mean), se)
    if acc.plan.errors:
        values["s2_temporal"] = Value(acc.still_variance, max(error, least))
    quartiles = np.array([0.25, 0.75])
    errors = QuantileErrors(
        acc.plan, acc.end_differences, acc.differences, quartiles, acc.difference_repeats
    )
    spread = float(errors.of(np.array([-1.0, 1.0]))) / 1.349
    values["temporal_noise_core"] = _log_core(acc.difference_sigma, spread, acc, drift=True)


def _pattern(acc: Accumulated, values: dict[str, Value]) -> None:
    levels = np.array([0.16, 0.25, 0.75, 0.84])
    spreads = np.array([[-0.5, 0.0, 0.0, 0.5], [0.0, -1 / 1.349, 1 / 1.349, 0.0]]).T
    errors = QuantileErrors(acc.plan, (acc.pattern,), acc.pattern_ordered, levels)
    core, quartiles = errors.of(spreads)
    width = float(errors.values @ spreads[:, 0])
    values["pattern_noise_core"] = _log_core(width, float(core), acc, drift=False)
    quartiles = float(quartiles) / acc.pattern_sigma
    clipped = acc.clipped_pattern
    middle = clipped.mean(dtype=np.float64).astype(np.float32)
    squares = block_sums(acc.plan, lambda rows: np.square(rows - middle), clipped)
    variance = float(squares.sum()) / acc.plan.pixels
    if variance > 0:
        # the cut moves with the robust sigma
        cut = CLIP * acc.pattern_sigma
        relative = 0.0
        if acc.plan.errors:
            limit = np.float32(0.999 * cut)
            cut_off = np.count_nonzero((clipped >= limit) | (clipped <= -limit))
            ends = cut_off / acc.plan.pixels * cut**2 / variance
            relative = mean_error(acc.plan, squares) / variance / 2 + ends * quartiles
        values["pattern_noise"] = Value(math.sqrt(variance), max(relative, 1e-6))


def emva_split(acc: Accumulated) -> dict[str, Value]:
    """Spatial nonuniformity and its row, column and pixel parts, EMVA 1288 release 4.0, DN.

    With M rows and N columns, s2 the variance over the pixels of the mean of K frames, s2_cav and
    s2_rav those of its column and row means, each less what the temporal noise leaves in it::

        row   = ((M N - N) s2_rav - M (s2 - s2_cav)) / (M N - M - N)
        col   = ((M N - M) s2_cav - N (s2 - s2_rav)) / (M N - M - N)
        pixel = M N (s2 - s2_cav - s2_rav) / (M N - M - N)

    The standard takes sigma2 / K off s2, sigma2 / (K M) off s2_cav and sigma2 / (K N) off s2_rav:
    that is white temporal noise of many frames. Rows and columns that move from frame to frame
    leave more, whole frames that drift leave nothing. So what is taken off the line means is
    the variance of theirs in the differences of frames, and the drift of whole frames is not in
    sigma2. For white noise both are the same.

    Needs two frames. A part whose variance comes out negative, for its true value is near 0, is
    stated as 0; its error is then that of a variance as large as its error.
    """
    pattern, (rows, columns) = acc.pattern, acc.plan.shape
    stack = acc.still_variance / acc.frames
    column_means = pattern.mean(axis=0, dtype=np.float64)
    row_means = pattern.mean(axis=1, dtype=np.float64)
    middle = np.float32(row_means.mean())
    squares = block_sums(acc.plan, lambda rows: np.square(rows - middle), pattern)
    total = float(squares.sum()) / acc.plan.pixels - stack
    total_se = mean_error(acc.plan, squares)
    out = {"dsnu_1288": _root(total, total_se)}
    size = rows * columns
    rest = size - rows - columns
    if rest <= 0:
        return out
    cav, cav_se = _of_lines(acc, column_means, axis=0)
    rav, rav_se = _of_lines(acc, row_means, axis=1)
    column = ((size - rows) * cav - columns * (total - rav)) / rest
    row = ((size - columns) * rav - rows * (total - cav)) / rest
    pixel = size * (total - cav - rav) / rest
    out["dsnu_1288_col"] = _root(column, cav_se)
    out["dsnu_1288_row"] = _root(row, rav_se)
    out["dsnu_1288_pix"] = _root(pixel, math.hypot(total_se, cav_se, rav_se))
    return out


def _of_lines(acc: Accumulated, means: np.ndarray, axis: int) -> tuple[float, float]:
    """Variance of the line means of F without what moves in time, DN^2, and its error."""
    moving = [float(np.var(d.mean(axis=axis, dtype=np.float64))) for d in acc.end_differences]
    share = float(np.mean(moving)) / acc.frames
    variance = float(np.var(means))
    lines = max(means.size - 1, 1)
    return variance - share, math.hypot(variance, share) * math.sqrt(2 / lines)


def _root(variance: float, se: float) -> Value:
    value = math.sqrt(max(variance, 0.0))
    return Value(value, max(se / (2 * max(value, math.sqrt(se / 2 + 1e-30))), 1e-9))
