"""Shading: how the DSNU, its scatter from pixel to pixel, and the noise vary over the field.

Cosine coefficients of block means. Charge has its shot noise with it, and a scatter of its own from
pixel to pixel; an offset of the readout has neither. Where the noise or the scatter is shaded like
the pattern, that is charge.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import scipy.fft

from dnanalyze.analyzers.accumulators.accumulated import Accumulated
from dnanalyze.analyzers.estimators.line_means import block_means, line_means
from dnanalyze.analyzers.families.family import FamilyResult
from dnanalyze.analyzers.statistics import Scale, StatisticInfo, Value

GRID = 16  # blocks along each side, at most
SMALLEST_BLOCK = 8  # pixels
ORDERS = 4  # coefficients of lower orders are told one by one
MID = (4, 8)  # orders, half open
HIGH = 8  # orders from here on
NOISE, SCATTER = "noise_shading_", "scatter_shading_"
RELATIVE = {NOISE: "noise_blocks", SCATTER: "scatter_blocks"}  # statistics, and their curves
RELATIVE_ORDERS = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))  # across, down
_REACH = 8.0  # times the typical temporal variance; a pixel's own is cut there
_RED = 4.0  # a random low-frequency field has more power in the orders below 4 than in 4 to 7

_NOISE_UNLIKE = (
    "the temporal dark noise varies over the field differently from the model: shading of the "
    "dark charge adds shot noise, shading by the readout does not"
)
_SCATTER_UNLIKE = (
    "the scatter of the DSNU from pixel to pixel varies over the field differently from the model: "
    "dark charge that differs from pixel to pixel is shaded, or grows while rows wait to be read"
)
_UNLIKE = (
    "the shading differs from the model's: amplifier glow, a thermal gradient, or a readout ramp"
)
_NONE = {
    NOISE: "needs two frames with noise between them, and five blocks along each side",
    SCATTER: "needs pixels that differ, and five blocks along each side",
}


def _order(i: int, j: int) -> StatisticInfo:
    title = f"shading of order {i} across, {j} down"
    return StatisticInfo(f"shading_{i}_{j}", "shading", "DN", title, high=_UNLIKE, low=_UNLIKE)


def _relative(name: str, what: str, i: int, j: int, unlike: str) -> StatisticInfo:
    title = f"shading of {what} of order {i} across, {j} down, over its mean"
    return StatisticInfo(f"{name}{i}_{j}", "shading", "1", title, high=unlike, low=unlike)


def _power(name: str, orders: str) -> StatisticInfo:
    return StatisticInfo(
        name, "shading", "DN^2", f"mean square of the shading of orders {orders}", Scale.LOG,
        high="the DSNU is more uneven over the field than in the model, {ratio} times in "
        "power: a low-frequency pattern is missing",
        low="the DSNU is more even over the field than in the model",
    )  # fmt: skip


INFOS: tuple[StatisticInfo, ...] = (
    *(_order(i, j) for i in range(ORDERS) for j in range(ORDERS) if i or j),
    _power("shading_mid", "4 to 7"),
    _power("shading_high", "8 to 15"),
    *(_relative(NOISE, "the temporal variance", *o, _NOISE_UNLIKE) for o in RELATIVE_ORDERS),
    *(
        _relative(SCATTER, "the DSNU's variance between neighbours", *o, _SCATTER_UNLIKE)
        for o in RELATIVE_ORDERS
    ),
)


def finish(acc: Accumulated) -> FamilyResult:
    """Cosine coefficients of the winsorised pattern, of the frame itself where there is one, of its
    variance between neighbours, and of the winsorised temporal variance.
    """
    image = acc.clipped_pattern
    shape = tuple(min(GRID, n // SMALLEST_BLOCK) for n in image.shape)
    if min(shape) < 2:
        why = f"needs two blocks of {SMALLEST_BLOCK} pixels along each side"
        return FamilyResult(missing={"shading": why})
    means = block_means(image, (shape[0], shape[1]))
    coefficients = _cosines(means)
    result = FamilyResult(curves={"block_means": means + acc.pattern_centre})
    _of_noise(acc, (shape[0], shape[1]), result)
    _of_scatter(acc, (shape[0], shape[1]), result)
    square, errors = coefficients**2, acc.plan.errors
    order, _ = _orders((square.shape[0], square.shape[1]))
    noise = [0.0, 0.0, 0.0]
    if errors:
        resolution = acc.pattern_step or 1e-6 * max(1.0, abs(acc.pattern_centre))
        noise = _noise(image, square, order, resolution / math.sqrt(12))
    for i in range(ORDERS):
        for j in range(ORDERS):
            name = f"shading_{i}_{j}"
            if i >= square.shape[0] or j >= square.shape[1]:
                result.missing[name] = "the frame has too few blocks for this order"
            elif i or j:
                variance = noise[_kind(i, j)]
                result.values[name] = Value(float(coefficients[i, j]), math.sqrt(variance))
    for name, inside in (
        ("shading_mid", (order >= MID[0]) & (order < MID[1])),
        ("shading_high", order >= HIGH),
    ):
        mean = float(square[inside].mean()) if inside.any() else 0.0
        if mean > 0:
            error = _relative_error(square, inside) if errors else 0.0
            result.values[name] = Value(mean, error)
        else:
            result.missing[name] = "the frame has too few blocks for these orders, or no pattern"
    return result


def _cosines(blocks: np.ndarray) -> np.ndarray:
    """Orthonormal coefficients, (across, down), in the unit of the blocks rms over the field."""
    return np.asarray(scipy.fft.dctn(blocks, norm="ortho").T / math.sqrt(blocks.size))


def _of_noise(acc: Accumulated, grid: tuple[int, int], result: FamilyResult) -> None:
    """Add the coefficients of the temporal variance over its mean."""
    typical, variance = acc.difference_sigma**2, acc.temporal_variance
    if variance is None or min(typical, acc.temporal_mean) <= 0:
        _add(NOISE, None, acc, grid, result)
    else:
        _add(NOISE, np.minimum(variance, np.float32(_REACH * typical)), acc, grid, result)


def _of_scatter(acc: Accumulated, grid: tuple[int, int], result: FamilyResult) -> None:
    """Add the coefficients of half the squared difference of neighbours in a row, over its mean.

    Offsets of rows are not in it, and those of columns are as large in every row.
    """
    step = np.diff(acc.clipped_pattern, axis=1)
    _add(SCATTER, np.float32(0.5) * step * step if step.any() else None, acc, grid, result)


def _add(
    name: str,
    variance: np.ndarray | None,
    acc: Accumulated,
    grid: tuple[int, int],
    result: FamilyResult,
) -> None:
    """Add the coefficients of a variance over its mean; why not, where there is none."""
    names = [f"{name}{i}_{j}" for i, j in RELATIVE_ORDERS]
    if variance is None or min(grid) <= MID[0]:
        result.missing.update(dict.fromkeys(names, _NONE[name]))
        return
    blocks = block_means(variance, grid)
    result.curves[RELATIVE[name]] = blocks
    coefficients = _cosines(blocks / blocks.mean())
    errors = _fine(coefficients**2) if acc.plan.errors else [0.0, 0.0, 0.0]
    for one, (i, j) in zip(names, RELATIVE_ORDERS, strict=True):
        result.values[one] = Value(float(coefficients[i, j]), errors[_kind(i, j)])


def _fine(square: np.ndarray) -> list[float]:
    """Root mean square of the coefficients of high orders of each kind, no less than of both."""
    order, kinds = _orders((square.shape[0], square.shape[1]))
    *lines, white = (float(square[(order >= MID[0]) & (kinds == k)].mean()) for k in range(3))
    return [math.sqrt(max(own, white, 1e-12)) for own in (*lines, white)]


def _kind(i: int, j: int) -> int:
    """0: varies across only, 1: down only, 2: both. Column and row offsets add to the first two."""
    return 0 if j == 0 else 1 if i == 0 else 2


@lru_cache(maxsize=64)
def _orders(shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Order and kind of each coefficient, (across, down)."""
    i, j = np.indices(shape)
    return np.maximum(i, j), np.where(j == 0, 0, np.where(i == 0, 1, 2))


def _noise(
    image: np.ndarray, square: np.ndarray, order: np.ndarray, resolution: float
) -> list[float]:
    """Variance of a low-order coefficient of each kind, DN^2.

    White pixels and white lines give every order alike. What the middle orders have beyond that is
    a random low-frequency field, which has more of it in the low orders.
    """
    lines = line_means(image)
    pixel = max(lines.variance, resolution**2) / image.size
    white = [_line_variance(m) / m.size for m in (lines.columns, lines.rows)] + [pixel]
    _, kinds = _orders((square.shape[0], square.shape[1]))
    middle = (order >= MID[0]) & (order < MID[1])
    out = []
    for kind, level in enumerate(white):
        level = max(level, pixel)
        inside = square[middle & (kinds == kind)]
        excess = 0.0
        if inside.size:
            chance = level * (1 + 2 * math.sqrt(2 / inside.size))
            if inside.mean() > chance:
                excess = float(inside.mean()) - level
        out.append(level + _RED * excess)
    return out


def _line_variance(means: np.ndarray) -> float:
    """Variance of line means by their middle frequencies: no shading, no odd and even lines."""
    square = scipy.fft.dct(means, norm="ortho") ** 2
    first = min(HIGH, means.size // 4)
    return float(np.mean(square[first : max(first + 1, means.size // 4)]))


def _relative_error(square: np.ndarray, inside: np.ndarray) -> float:
    """Relative standard error of a mean square of Gaussian coefficients, alike within a kind."""
    kinds = _orders((square.shape[0], square.shape[1]))[1][inside]
    values = square[inside]
    total = variance = 0.0
    for kind in range(3):
        members = values[kinds == kind]
        if members.size:
            total += float(members.sum())
            variance += 2.0 * members.size * float(members.mean()) ** 2
    return math.sqrt(variance) / total
