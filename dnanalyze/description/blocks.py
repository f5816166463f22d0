"""Blocks of pixels that share a value: their size and phase from neighbouring products."""

from __future__ import annotations

import numpy as np

from dnanalyze.description.layers import Layers

MOST = 64  # pixels, the largest block
SIGNIFICANT = 6.0  # standard errors of the correlation within blocks


def block_form(seen: Layers, maps: np.ndarray) -> tuple[int, int, int, int] | None:
    """Height, width, top and left of blocks in maps of unit noise, (..., rows, columns)."""
    stack = maps.reshape(-1, *maps.shape[-2:])
    stack = stack - stack.mean(axis=2, keepdims=True) - stack.mean(axis=1, keepdims=True)
    across = np.mean(stack[:, :, 1:] * stack[:, :, :-1], axis=(0, 1))
    down = np.mean(stack[:, 1:] * stack[:, :-1], axis=(0, 2))
    width = period(across, seen.window.left, stack.shape[0] * stack.shape[1])
    height = period(down, seen.window.top, stack.shape[0] * stack.shape[2])
    if width is None and height is None:
        return None
    (h, top), (w, left) = height or (1, 0), width or (1, 0)
    return h, w, top, left


def period(products: np.ndarray, first: int, count: int) -> tuple[int, int] | None:
    """Size and phase of blocks from products of neighbours along a line.

    Within blocks of n pixels n - 1 of n products are rho, the n-th is 0. None where no size stands
    out of its own chance, or where the products do not depend on the phase.
    """
    error2 = 1.0 / count
    number = np.arange(products.size) + first
    squares = products**2
    best, found = SIGNIFICANT**2, None
    for size in range(2, min(MOST, products.size // 2) + 1):
        which = number % size  # a seam lies after every pixel of one of these residues
        seams = np.bincount(which, minlength=size)
        inside = products.size - seams
        between = np.bincount(which, products, minlength=size)
        ragged = np.bincount(which, squares, minlength=size)
        level = (products.sum() - between) / inside
        step = level - between / seams
        gain = np.where(step > 0, step**2 / (error2 * (1.0 / inside + 1.0 / seams)), 0.0)
        # the seams must lie at 0 and the rest alike, beside the step itself
        misfit = ragged / error2 - seams
        misfit += (squares.sum() - ragged - inside * level**2) / error2 - inside
        worth = gain - np.maximum(misfit, 0.0)
        residue = int(worth.argmax())
        if worth[residue] > best:
            best, found = float(worth[residue]), (size, (size - 1 - residue) % size)
    return found


def block_means(
    seen: Layers, map_: np.ndarray, form: tuple[int, int, int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Mean of every block and the number of its pixels."""
    height, width, top, left = form
    rows = (seen.row + top) // height
    columns = (seen.column + left) // width
    number = (rows - rows.min()) * (int(np.ptp(columns)) + 1) + columns - columns.min()
    count = np.bincount(number.ravel())
    means = np.bincount(number.ravel(), map_.ravel()) / np.maximum(count, 1)
    return means[count > 0], count[count > 0]
