"""Level and low-order shading over the whole field, from one colour of a checkerboard of blocks.

Shading has one realisation a sensor, so it cannot be split into halves of the field as the rest is:
the fit sees the even blocks of the whole field and is judged on the odd ones. The level goes with
it: halves of the field whose levels differ are shaded, not wrong in level.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from dnanalyze.analyzers.families.shading import RELATIVE, RELATIVE_ORDERS
from dnanalyze.analyzers.statistics import SettingStatistics, Value
from dnanalyze.significance import TOLERATED

ORDER = 4  # cosines across the field: slopes, bows and edges; clouds are left to the spectrum
WIDE = 2 * ORDER  # surfaces from ORDER on tell the scatter of those below
LEVELS = ("mean", "median")


@dataclass(frozen=True)
class _Basis:
    """Cosine surfaces of order < WIDE at the blocks of one colour, low orders first.

    Parameters
    ----------
    surfaces : ndarray
        (blocks, surfaces).
    inverse : ndarray
        Their pseudo-inverse.
    places : ndarray
        Of the blocks among all.
    low : list of (int, (int, int))
        Numbers and orders (across, down) of those below ORDER save the mean.
    following : dict
        Axes along which surfaces vary, see `_kind`, to the numbers of those from ORDER on.
    """

    surfaces: np.ndarray
    inverse: np.ndarray
    places: np.ndarray
    low: list[tuple[int, tuple[int, int]]]
    following: dict[str, list[int]]


@lru_cache(maxsize=32)
def _basis(rows: int, cols: int, parity: int) -> _Basis:
    top = min(WIDE, rows // 2, cols // 2)
    orders = sorted(
        ((i, j) for i in range(top) for j in range(top)), key=lambda o: (max(o), o[0] + o[1], o)
    )
    y = np.cos(np.pi * np.outer(np.arange(rows) + 0.5, np.arange(top)) / rows)
    x = np.cos(np.pi * np.outer(np.arange(cols) + 0.5, np.arange(top)) / cols)
    r, c = np.nonzero((np.add.outer(np.arange(rows), np.arange(cols)) % 2) == parity)
    scale = [(np.sqrt(2) if i else 1) * (np.sqrt(2) if j else 1) for i, j in orders]
    design = np.stack([x[c, i] * y[r, j] * s for (i, j), s in zip(orders, scale, strict=True)], 1)
    low = [(k, order) for k, order in enumerate(orders) if 0 < max(order) < ORDER]
    # Rows and columns that vary at random show along their own axis only.
    following: dict[str, list[int]] = {_kind(order): [] for _, order in low}
    for k, order in enumerate(orders):
        if max(order) >= ORDER:
            following[_kind(order)].append(k)
    return _Basis(design, np.linalg.pinv(design), r * cols + c, low, following)


def shading_values(
    upper: SettingStatistics, lower: SettingStatistics, parity: int
) -> dict[str, Value]:
    """Low-order coefficients, DN rms over the field, and the level, DN, with their errors.

    Parameters
    ----------
    upper, lower : SettingStatistics
        Halves of the field; their curves ``block_means``, DN, and those of `RELATIVE`.
    parity : int
        Which colour of the checkerboard.

    Returns
    -------
    dict
        shading_i_j, order i across and j down, for i, j < 4 save 0_0, and noise_shading_i_j and
        scatter_shading_i_j of variances over their mean. The squared error is that of the white
        residue plus the power of the next orders of its kind: a random low-frequency field shows
        there, and a second sensor would draw it anew. ``mean`` and ``median`` of the half are
        moved by how far the blocks of the colour lie from its own; the median by what of that is
        no scatter.
    """
    blocks = _whole(upper, lower, "block_means")
    if blocks is None:
        return {}
    found = {f"shading_{i}_{j}": v for (i, j), v in _surfaces(blocks, parity).items()}
    half = (upper, lower)[parity]
    colour = blocks.ravel()[_basis(*blocks.shape, parity).places]
    shift = float(colour.mean() - half.curves["block_means"].mean())
    levels = {n: half.values[n] for n in LEVELS if n in half.values}
    moved = {n: replace(v, value=v.value + shift) for n, v in levels.items()}
    if "median" in levels:  # few bright pixels scatter the means of blocks, by which it is moved
        own, error = levels["median"], _shift_error(blocks, colour.size)
        share = max(0.0, 1.0 - (TOLERATED * error / shift) ** 2) if shift else 0.0
        se = math.hypot(own.se, share * error)
        moved["median"] = replace(own, value=own.value + share * shift, se=se)
    return found | moved | _of_variances(upper, lower, parity)


def _shift_error(blocks: np.ndarray, count: int) -> float:
    """Standard error of a mean of so many blocks, from differences of neighbours.

    Along the axis where these are smaller, so that a half of another level is no scatter.
    """
    apart = min(float(np.mean(np.diff(blocks, axis=axis) ** 2)) for axis in (0, 1))
    return math.sqrt(apart / 2.0 / count)


def _of_variances(
    upper: SettingStatistics, lower: SettingStatistics, parity: int
) -> dict[str, Value]:
    """How the temporal variance and the scatter of the DSNU vary over the field, over their means
    there.
    """
    values: dict[str, Value] = {}
    for name, curve in RELATIVE.items():
        blocks = _whole(upper, lower, curve)
        if blocks is not None:
            found = _surfaces(blocks / blocks.mean(), parity)
            values |= {f"{name}{i}_{j}": found[i, j] for i, j in RELATIVE_ORDERS}
    return values


def _whole(upper: SettingStatistics, lower: SettingStatistics, name: str) -> np.ndarray | None:
    """Blocks of the whole field; None where there are none, or too few."""
    if name not in upper.curves or name not in lower.curves:
        return None
    blocks = np.concatenate([upper.curves[name], lower.curves[name]])
    usable = min(blocks.shape) >= 2 * ORDER and np.isfinite(blocks).all()
    return blocks if usable else None


def _surfaces(blocks: np.ndarray, parity: int) -> dict[tuple[int, int], Value]:
    """Coefficients below `ORDER`, rms over the field, by their orders (across, down)."""
    basis = _basis(*blocks.shape, parity)
    here = blocks.ravel()[basis.places]
    coefficient = basis.inverse @ here
    residue = here - basis.surfaces @ coefficient
    freedom = max(1, len(here) - len(coefficient))
    white = residue @ residue / freedom / len(here)
    errors = {}
    for kind, alike in basis.following.items():
        next_power = np.mean(coefficient[alike] ** 2) if alike else white
        errors[kind] = max(float(np.sqrt(white + 4.0 * max(0.0, next_power - white))), 1e-4)
    return {order: Value(float(coefficient[k]), errors[_kind(order)]) for k, order in basis.low}


def _kind(order: tuple[int, int]) -> str:
    """Whether a cosine surface varies along rows, along columns, or both."""
    return "both" if order[0] and order[1] else "columns" if order[0] else "rows"
