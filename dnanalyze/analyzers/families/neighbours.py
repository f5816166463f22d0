"""Pixels and their neighbours: correlations, ranks, halos of hot pixels, local variances."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.accumulators.neighbour_sums import (
    EXCESS_SIGMAS,
    LAGS,
    lag_products,
    rank_shares,
)
from dnanalyze.analyzers.estimators.halo import FEWEST, halo
from dnanalyze.analyzers.estimators.uncertainty import clustered_variance
from dnanalyze.analyzers.families.family import FamilyResult
from dnanalyze.analyzers.families.neighbours_infos import INFOS, LAG_NAMES
from dnanalyze.analyzers.kernels.layout import (
    HAAR_COUNT,
    HAAR_FOURTH,
    HAAR_SECOND,
    PEAK_EXCESS,
    PEAK_TIES,
    PEAK_TOP,
    RANK_HIGH,
    RANK_LOW,
    RANK_PIXELS,
    TILE_COUNT,
    TILE_SQUARE,
    TILE_VARIANCE,
)
from dnanalyze.analyzers.plan import CLIP, Plan
from dnanalyze.analyzers.statistics import Value

__all__ = ["INFOS", "finish"]

SMALLEST_SIDE = 8  # pixels
_FEWEST_FRAMES = 3  # whose scatter tells something
_RANK_SD = 9 * 0.157  # of 9 P_max for n exchangeable pixels, times sqrt(n)
BANDS = 16  # of rows, whose scatter is the error of what clusters make, known to 1/sqrt(30)
_ROOT_FLOOR = 0.375  # variance of a count that may be 0


@dataclass(frozen=True)
class _Sums:
    """Sums over the frames by block, (row bands, column bands, sums), and by frame, (n, sums).

    ``frames`` counts the frames, or the differences, in them; ``overlap`` is by how much
    neighbouring differences, which share a frame, repeat one another.
    """

    plan: Plan
    blocks: np.ndarray
    each: np.ndarray
    overlap: float = 1.0

    @property
    def frames(self) -> int:
        return len(self.each)

    @cached_property
    def total(self) -> np.ndarray:
        return np.asarray(self.blocks.sum(axis=(0, 1)))

    def error(self, weights: dict[int, float]) -> float:
        """Standard error of a combination of the sums whose total is 0 (a linearised statistic).

        From the scatter of the blocks; or from that of the frames, where something that whole
        frames share makes it larger beyond doubt.
        """
        if not self.plan.errors:
            return 0.0
        combine = np.zeros(self.total.size)
        combine[list(weights)] = list(weights.values())
        variance = max(0.0, float(clustered_variance(self.blocks @ combine)))
        n = self.frames
        if n >= _FEWEST_FRAMES:
            residuals = self.each @ combine
            frames = float(residuals @ residuals) * n / (n - 1) * self.overlap
            if frames > variance * (1 + 3 * math.sqrt(2 / (n - 1))):
                variance = frames
        return math.sqrt(variance)


def finish(acc: Accumulated) -> FamilyResult:
    """Values of one setting."""
    plan, sums = acc.plan, acc.neighbours
    if min(plan.shape) < SMALLEST_SIDE:
        why = f"statistics of neighbours need {SMALLEST_SIDE} pixels along each side"
        return FamilyResult(missing={"neighbours": why})
    result = FamilyResult()
    peaks = _Sums(plan, sums.peaks, np.array(sums.each["peaks"]))
    _ranks("frame", peaks, result)
    _peaks(peaks, result)
    once = np.empty(0)
    products = lag_products(plan, acc.clipped_pattern, CLIP * acc.pattern_sigma)
    # with several frames, the correlations of one follow from those of DSNU and temporal noise
    part = "pattern" if acc.frames > 1 else "frame"
    _correlations(part, _Sums(plan, products, once), result)
    if acc.frames > 1:
        _ranks("pattern", _Sums(plan, rank_shares(plan, acc.pattern), once), result)
        overlap = sums.differences / acc.difference_repeats
        ranks, lags, tiles = (
            _Sums(plan, getattr(sums, name), np.array(sums.each[name]), overlap)
            for name in ("ranks", "lags", "tiles")
        )
        _ranks("temporal", ranks, result)
        _correlations("temporal", lags, result)
        if plan.errors:
            inner = _Sums(plan, sums.inner, np.array(sums.each["inner"]), overlap)
            result.curves["noise_correlation"] = _inner(inner)
        _local_variances(tiles, result)
        _shared_noise(acc, result)
    else:
        why = "one frame does not separate DSNU and temporal noise"
        result.missing["neighbours"] = why
    _halos(acc, result)
    return result


def _shared_noise(acc: Accumulated, result: FamilyResult) -> None:
    """Whether pixels are noisy together in pairs that begin at even lines.

    By v / (v + typical), which few noisy pixels do not govern, about the means of rows and columns.
    Twice the size of the correlation in the other pairs is taken off: clouds of noise correlate
    both alike, groups of four lines and more the others half as much, and interference of 8 columns
    a period, whose variance has 4, correlates one as much as it anticorrelates the other.
    """
    from dnanalyze.analyzers.kernels import pixel_loops

    variance, typical = acc.temporal_variance, np.float32(acc.difference_sigma**2)
    assert variance is not None
    names = [f"noise_shared_{lines}" for lines in ("columns", "rows")]
    bands = np.zeros((BANDS, 5))
    if typical > 0:
        pixel_loops.pair_products(variance / (variance + typical), bands)
    sums = bands.sum(axis=0)
    if not sums[4] > 0:
        result.missing.update(dict.fromkeys(names, "all pixels are equally noisy"))
        return
    rows, columns = acc.plan.shape
    for name, lines, k in zip(names, (columns, rows), (0, 2), strict=True):
        across = rows * columns // lines
        within, between = across * (lines // 2), across * ((lines - 1) // 2)
        other = math.copysign(2.0 * rows * columns / sums[4] / between, sums[k + 1])
        each = bands[:, k] * (rows * columns / sums[4] / within) - bands[:, k + 1] * other
        value = float(each.sum())
        rest = each - value * bands[:, 4] / sums[4]
        # at least that of products of independent pixels of unit variance
        error = max(1.0 / within + 4.0 / between, float(rest @ rest) * BANDS / (BANDS - 1))
        result.values[name] = Value(value, math.sqrt(error))


def _ranks(part: str, sums: _Sums, result: FamilyResult) -> None:
    pixels = float(sums.total[RANK_PIXELS])
    for name, at in (("pmax8", RANK_HIGH), ("pmin8", RANK_LOW)):
        share = float(sums.total[at]) / pixels
        error = 9 * sums.error({at: 1.0, RANK_PIXELS: -share}) / pixels
        result.values[f"{part}_{name}"] = Value(9 * share, max(error, _RANK_SD / math.sqrt(pixels)))


def _correlations(part: str, sums: _Sums, result: FamilyResult) -> None:
    names = [f"{part}_corr_{name}" for name in LAG_NAMES]
    if sums.total[0] > 0:
        result.values.update(zip(names, _at_lags(sums), strict=True))
    else:
        result.missing.update(dict.fromkeys(names, "all pixels are equal"))


def _inner(sums: _Sums) -> np.ndarray:
    """Correlations at the lags without outlying pixels, and their standard errors, (lags, 2).

    Of n pixels m are left, and of n pairs m^2 / n.
    """
    if not sums.total[0] > 0:
        return np.empty((0, 2))
    pixels = math.prod(sums.plan.shape) * sums.frames
    share = float(sums.total[len(LAGS)]) / pixels
    return np.array([(v.value, v.se) for v in _at_lags(sums)]) / share


def _at_lags(sums: _Sums) -> list[Value]:
    """Covariance at each lag but the first over the variance.

    Removing the row means took 1/columns off the correlation along a row, removing the column means
    1/rows off that along a column; this is put back.
    """
    rows, columns = sums.plan.shape
    variance, found = float(sums.total[0]), []
    for at, (dx, dy) in enumerate(LAGS[1:], 1):
        scale = rows * columns / ((rows - dy) * (columns - dx))
        ratio = float(sums.total[at]) / variance
        value = ratio * scale + (1 / columns if dy == 0 else 0) + (1 / rows if dx == 0 else 0)
        error = sums.error({at: 1.0, 0: -ratio}) / variance * scale
        floor = 0.5 / math.sqrt(rows * columns * max(1, sums.frames))
        found.append(Value(value, max(error, floor)))
    return found


def _peaks(sums: _Sums, result: FamilyResult) -> None:
    pixels, frames = float(sums.total[RANK_PIXELS]), sums.frames
    for k, sigmas in enumerate(EXCESS_SIGMAS):
        at = PEAK_EXCESS + k
        count = float(sums.total[at]) / frames
        error = sums.error({at: 1.0, RANK_PIXELS: -count * frames / pixels}) / frames
        variance = max(error**2, _ROOT_FLOOR)
        result.values[f"excess_{sigmas:g}"] = Value(count, math.sqrt(variance / (count + 0.375)))
    n = float(sums.total[PEAK_TOP])
    if not n > 0:
        result.missing["ties_max8"] = "no inner pixel is among the top 1 %"
        return
    share = float(sums.total[PEAK_TIES]) / n
    floor = math.sqrt(max(share * (1 - share), 1.0 / n) / n)  # none seen: one might have been
    error = sums.error({PEAK_TIES: 1.0, PEAK_TOP: -share}) / n
    result.values["ties_max8"] = Value(share, max(error, floor))


def _local_variances(sums: _Sums, result: FamilyResult) -> None:
    """CV^2 of the variances of 4x4 tiles (Gaussian: 2/15), kurtosis of the diagonal Haar band."""
    n = float(sums.total[TILE_COUNT])
    m1, m2 = (float(sums.total[at]) / n for at in (TILE_VARIANCE, TILE_SQUARE))
    if m1 > 0 and m2 > m1**2:
        cv = m2 / m1**2 - 1
        slope = 2 * m2 / m1**3
        weights = {TILE_SQUARE: m1**-2, TILE_VARIANCE: -slope, TILE_COUNT: m2 / m1**2}
        error = max(sums.error(weights) / n / cv, math.sqrt(2 / n) / 5)
        result.values["local_variance_cv"] = Value(cv, error)
    else:
        result.missing["local_variance_cv"] = "the temporal dark noise is the same in all tiles"
    n = float(sums.total[HAAR_COUNT])
    m2, m4 = (float(sums.total[at]) / n for at in (HAAR_SECOND, HAAR_FOURTH))
    if not m2 > 0:
        result.missing["hh_kurtosis"] = "the frames do not differ between neighbours"
        return
    slope = 2 * m4 / m2**3
    weights = {HAAR_FOURTH: m2**-2, HAAR_SECOND: -slope, HAAR_COUNT: m4 / m2**2}
    error = max(sums.error(weights) / n, math.sqrt(6 / n))
    result.values["hh_kurtosis"] = Value(m4 / m2**2 - 3, error)


def _halos(acc: Accumulated, result: FamilyResult) -> None:
    quarter, middle = acc.pattern_ordered.quantile(np.array([0.25, 0.5]))
    sigma = float(middle - quarter) / 0.6745 or acc.pattern_sigma
    rings = halo(acc.pattern, acc.pattern_centre, sigma)
    for ring, name in ((1, "hot_halo"), (2, "hot_halo_2")):
        if ring in rings:
            result.values[name] = rings[ring]
        else:
            result.missing[name] = f"fewer than {FEWEST} isolated hot pixels above 16 sigma"
