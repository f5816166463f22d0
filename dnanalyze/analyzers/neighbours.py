"""Pixels and their neighbours: covariances, ranks, halos, peaks, local variances."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.analyzers.family import Accumulated, FamilyResult
from dnanalyze.analyzers.halo import FEWEST, halo
from dnanalyze.analyzers.neighbours_accumulator import (
    EXCESS_SIGMAS,
    LAGS,
    PEAK_EXCESS,
    PEAK_TIES,
    PEAK_TOP,
    RANK_HIGH,
    RANK_LOW,
    RANK_PIXELS,
    Neighbours,
    lag_products,
    rank_shares,
)
from dnanalyze.analyzers.neighbours_infos import INFOS, LAG_NAMES
from dnanalyze.analyzers.plan import CLIP, Plan
from dnanalyze.analyzers.statistics import Value
from dnanalyze.analyzers.uncertainty import clustered_variance

__all__ = ["INFOS", "finish"]

SMALLEST_SIDE = 8  # pixels
_BLOCK = 24  # pixels along a side of a block, at least: ranks of neighbours are correlated
_RANK_SD = 9 * 0.157  # of 9 P_max for n exchangeable pixels, times sqrt(n)
_ROOT_FLOOR = 0.375  # variance of a count that may be 0


def finish(acc: Accumulated) -> FamilyResult:
    """Values of one setting."""
    plan, sums = acc.plan, acc.neighbours
    if min(plan.shape) < SMALLEST_SIDE:
        why = f"statistics of neighbours need {SMALLEST_SIDE} pixels along each side"
        return FamilyResult(missing={"neighbours": why})
    result = FamilyResult()
    _ranks("frame", plan, sums.peaks, acc.frames, result)
    _peaks(plan, sums, result)
    if acc.frames > 1:
        _ranks("pattern", plan, rank_shares(plan, acc.pattern), 1, result)
        products = lag_products(plan, acc.clipped_pattern, CLIP * acc.pattern_sigma)
        _correlations("pattern", plan, products, 1, result)
        _ranks("temporal", plan, sums.ranks, sums.differences, result)
        _correlations("temporal", plan, sums.lags, sums.differences, result)
        _local_variances(plan, sums.tiles, result)
    else:
        why = "one frame does not tell the fixed pattern from the temporal noise"
        result.missing["neighbours"] = why
    _halos(acc, result)
    return result


def _coarse(plan: Plan, sums: np.ndarray) -> np.ndarray:
    """Block sums on a grid whose blocks have 24 pixels or more along a side where they can."""
    for axis, size in enumerate(plan.shape):
        bands = sums.shape[axis]
        wanted = max(1, min(bands, size // _BLOCK))
        sums = np.add.reduceat(sums, np.arange(wanted) * bands // wanted, axis=axis)
    return sums


def _error(plan: Plan, residuals: np.ndarray) -> float:
    """Standard error of a sum over blocks, from their residuals, (row bands, column bands)."""
    return math.sqrt(max(0.0, float(clustered_variance(_coarse(plan, residuals)))))


def _ranks(part: str, plan: Plan, sums: np.ndarray, frames: int, result: FamilyResult) -> None:
    pixels = sums[..., RANK_PIXELS]
    total = float(pixels.sum())
    for name, at in (("pmax8", RANK_HIGH), ("pmin8", RANK_LOW)):
        share = float(sums[..., at].sum()) / total
        error = 9 * _error(plan, sums[..., at] - share * pixels) / total
        floor = _RANK_SD / math.sqrt(total)
        result.values[f"{part}_{name}"] = Value(9 * share, max(error, floor))


def _correlations(
    part: str, plan: Plan, products: np.ndarray, frames: int, result: FamilyResult
) -> None:
    """Covariance at each lag over the variance.

    Removing the row means took 1/columns off the correlation along a row, removing the column means
    1/rows off that along a column; this is put back.
    """
    rows, columns = plan.shape
    variance = products[..., 0]
    total = float(variance.sum())
    for (dx, dy), name in zip(LAGS[1:], LAG_NAMES, strict=True):
        if not total > 0:
            result.missing[f"{part}_corr_{name}"] = "all pixels are alike"
            continue
        scale = rows * columns / ((rows - dy) * (columns - dx))
        each = products[..., LAGS.index((dx, dy))]
        ratio = float(each.sum()) / total
        value = ratio * scale + (1 / columns if dy == 0 else 0) + (1 / rows if dx == 0 else 0)
        error = _error(plan, each - ratio * variance) / total * scale
        floor = 0.5 / math.sqrt(rows * columns * frames)
        result.values[f"{part}_corr_{name}"] = Value(value, max(error, floor))


def _peaks(plan: Plan, sums: Neighbours, result: FamilyResult) -> None:
    peaks, frames = sums.peaks, sums.frames
    pixels = peaks[..., RANK_PIXELS]
    for k, sigmas in enumerate(EXCESS_SIGMAS):
        counts = peaks[..., PEAK_EXCESS + k] / frames
        total = float(counts.sum())
        residuals = counts - pixels * (total / float(pixels.sum()))
        variance = max(_error(plan, residuals) ** 2, _ROOT_FLOOR)
        result.values[f"excess_{sigmas:g}"] = Value(total, math.sqrt(variance / (total + 0.375)))
    top, ties = peaks[..., PEAK_TOP], peaks[..., PEAK_TIES]
    n = float(top.sum())
    if not n > 0:
        result.missing["ties_max8"] = "no inner pixel is among the top 1 %"
        return
    share = float(ties.sum()) / n
    floor = math.sqrt(max(share * (1 - share), 0.1 / n) / n)
    error = _error(plan, ties - share * top) / n
    result.values["ties_max8"] = Value(share, max(error, floor))


def _local_variances(plan: Plan, tiles: np.ndarray, result: FamilyResult) -> None:
    """CV^2 of the variances of 4x4 tiles (Gaussian: 2/15), kurtosis of the diagonal Haar band."""
    count, variance, square, number, second, fourth = np.moveaxis(tiles, -1, 0)
    n, m1 = float(count.sum()), float(variance.sum())
    if not m1 > 0:
        why = "the frames do not differ"
        result.missing.update({"local_variance_cv": why, "hh_kurtosis": why})
        return
    m1, m2 = m1 / n, float(square.sum()) / n
    cv = m2 / m1**2 - 1
    slope = (square - m2 * count) / m1**2 - 2 * m2 * (variance - m1 * count) / m1**3
    floor = math.sqrt(2 / n) / 5
    if cv > 0:
        error = max(_error(plan, slope) / n / cv, floor)
        result.values["local_variance_cv"] = Value(cv, error)
    else:
        result.missing["local_variance_cv"] = "the local variances are all alike"
    n = float(number.sum())
    m2, m4 = float(second.sum()) / n, float(fourth.sum()) / n
    if not m2 > 0:
        result.missing["hh_kurtosis"] = "the frames do not differ between neighbours"
        return
    slope = (fourth - m4 * number) / m2**2 - 2 * m4 * (second - m2 * number) / m2**3
    result.values["hh_kurtosis"] = Value(
        m4 / m2**2 - 3, max(_error(plan, slope) / n, math.sqrt(6 / n))
    )


def _halos(acc: Accumulated, result: FamilyResult) -> None:
    quarter, middle = acc.pattern_ordered.quantile(np.array([0.25, 0.5]))
    sigma = float(middle - quarter) / 0.6745 or acc.pattern_sigma
    found = halo(acc.pattern, acc.pattern_centre, sigma)
    for ring, name in ((1, "hot_halo"), (2, "hot_halo_2")):
        if ring in found:
            result.values[name] = found[ring]
        else:
            result.missing[name] = f"fewer than {FEWEST} isolated hot pixels above 16 sigma"
