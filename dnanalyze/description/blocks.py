"""Blocks of pixels that share a value: their size and phase from sums of neighbours."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.description.layers import Layers
from dnanalyze.significance import CERTAIN

MAX_BLOCK = 64  # pixels, the largest block
SCALES = (1, 2, 4, 8)  # pixels across the axis, of which means are taken


def block_form(seen: Layers, maps: np.ndarray) -> tuple[int, int, int, int] | None:
    """Height, width, top and left of blocks in maps of unit noise, (..., rows, columns).

    The period along one axis is looked for in means over `SCALES` pixels of the other, which
    raise the share of the blocks in the variance; the axis that is clearer first, then the other in
    means over the blocks of the first.
    """
    stack = maps.reshape(-1, *maps.shape[-2:])
    stack = stack - stack.mean(axis=2, keepdims=True) - stack.mean(axis=1, keepdims=True)
    turned = stack.transpose(0, 2, 1)
    first = seen.window.top, seen.window.left
    across = max((_along(stack, first[1], n, 0) for n in SCALES), key=lambda x: x[0])
    down = max((_along(turned, first[0], n, 0) for n in SCALES), key=lambda x: x[0])
    if across[1] is None and down[1] is None:
        return None
    if across[0] >= down[0]:
        assert across[1] is not None
        width, left = across[1]
        cut = -(first[1] + left) % width
        again = _along(turned, first[0], width, cut)
        down = max(down, again, key=lambda x: x[0])
    else:
        assert down[1] is not None
        height, top = down[1]
        cut = -(first[0] + top) % height
        again = _along(stack, first[1], height, cut)
        across = max(across, again, key=lambda x: x[0])
    (h, top), (w, left) = down[1] or (1, 0), across[1] or (1, 0)
    return h, w, top, left


def _along(
    stack: np.ndarray, first: int, over: int, cut: int
) -> tuple[float, tuple[int, int] | None]:
    """Worth and form of blocks along the last axis, in means over ``over`` lines from ``cut``."""
    count = (stack.shape[1] - cut) // over
    if count < 2:
        return 0.0, None
    lines = stack[:, cut : cut + count * over].reshape(len(stack), count, over, -1).mean(axis=2)
    lines = (lines * np.float32(math.sqrt(over))).reshape(-1, lines.shape[-1])
    return _period(lines, first)


def _period(lines: np.ndarray, first: int) -> tuple[float, tuple[int, int] | None]:
    """Worth, and size and phase, of blocks along lines of unit noise.

    Sums over n pixels scatter most where they lie on blocks of n and least half a block beside:
    by A^2 n / 2 of blocks of variance A^2, and by a quarter of that or less with 2 n or n / 2
    pixels. Half of the pixels are common to both, so that the difference of the two mean squares
    of m sums has by chance a variance of 2 / m, for pixels of variance 1.
    """
    most = min(MAX_BLOCK, lines.shape[1] // 4)
    products = [
        np.einsum("ij,ij->j", lines[:, lag:], lines[:, : lines.shape[1] - lag]) / len(lines)
        for lag in range(most)
    ]
    sums = [np.concatenate([[0.0], np.cumsum(x, dtype=float)]) for x in products]
    power = float(products[0].mean())
    best, found = CERTAIN**2, None
    for size in range(2, most + 1):
        places = lines.shape[1] - size + 1
        square = np.zeros(places)
        for lag in range(size):
            end = size - lag
            square += (1.0 if lag == 0 else 2.0) * (
                sums[lag][end : end + places] - sums[lag][:places]
            )
        square /= size
        phase = np.arange(places) % size
        count = np.bincount(phase, minlength=size)
        mean = np.bincount(phase, square, minlength=size) / count
        beside = np.roll(mean, -(size // 2))
        step = np.maximum(mean - beside, 0.0)
        worth = step**2 * count * len(lines) / (2.0 * power**2)
        at = int(worth.argmax())
        if worth[at] > best:
            best, found = float(worth[at]), (size, -(at + first) % size)
    return (best if found else 0.0), found


def block_means(
    seen: Layers, map_: np.ndarray, form: tuple[int, int, int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Mean of every block, less that of all, and the number of its pixels."""
    height, width, top, left = form
    rows = (seen.row + top) // height
    columns = (seen.column + left) // width
    number = (rows - rows.min()) * (int(np.ptp(columns)) + 1) + columns - columns.min()
    count = np.bincount(number.ravel())
    rest = map_ - map_.mean()  # a skew map has its median at 0, not its mean
    means = np.bincount(number.ravel(), rest.ravel()) / np.maximum(count, 1)
    return means[count > 0], count[count > 0]
