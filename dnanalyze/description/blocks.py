"""Blocks of pixels that share a value: their size and phase from sums of neighbours."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dnanalyze.description.layers import Layers
from dnanalyze.significance import CERTAIN

MAX_BLOCK = 64  # pixels, the largest block
SCALES = (1, 2, 4, 8)  # pixels across the axis, of which means are taken


class Period(NamedTuple):
    """Blocks along an axis: how clear they are, their pixels (1: none), and those that are cut."""

    worth: float = 0.0
    size: int = 1
    cut: int = 0


def block_form(seen: Layers, maps: np.ndarray) -> tuple[int, int, int, int] | None:
    """Height, width, top and left of blocks in maps of unit noise, (..., rows, columns).

    The period along one axis is looked for in means over `SCALES` pixels of the other, which
    raise the share of the blocks in the variance; the axis that is clearer first, then the other in
    means over the blocks of the first.
    """
    stack = maps.reshape(-1, *maps.shape[-2:])
    stack = stack - stack.mean(axis=2, keepdims=True) - stack.mean(axis=1, keepdims=True)
    lines = stack.transpose(0, 2, 1), stack  # down the columns, along the rows
    first = seen.window.top, seen.window.left
    found = [max(_along(lines[a], first[a], n, 0) for n in SCALES) for a in (0, 1)]
    clear = int(found[1] >= found[0])
    if found[clear].size == 1:
        return None
    other, (_, size, cut) = 1 - clear, found[clear]
    again = _along(lines[other], first[other], size, -(first[clear] + cut) % size)
    (_, height, top), (_, width, left) = (
        max(of, again) if n == other else of for n, of in enumerate(found)
    )
    return height, width, top, left


def _along(stack: np.ndarray, first: int, over: int, cut: int) -> Period:
    """Blocks along the last axis, in means over ``over`` lines from ``cut``."""
    count = (stack.shape[1] - cut) // over
    if count < 2:
        return Period()
    lines = stack[:, cut : cut + count * over].reshape(len(stack), count, over, -1).mean(axis=2)
    lines = (lines * np.float32(math.sqrt(over))).reshape(-1, lines.shape[-1])
    return _period(lines, first)


def _period(lines: np.ndarray, first: int) -> Period:
    """Blocks along lines of unit noise.

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
    best = Period(CERTAIN**2)
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
        if worth[at] > best.worth:
            best = Period(float(worth[at]), size, -(at + first) % size)
    return best if best.size > 1 else Period()
