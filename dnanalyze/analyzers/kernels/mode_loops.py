"""Compiled loops over Fourier modes, (rows, columns // 2 + 1)."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from dnanalyze.analyzers.kernels.pixel_loops import LANES, folded


@njit(cache=True, nogil=True)
def add_power(total, transform, scale):
    """total += |transform|^2 scale; the mean's mode is left out."""
    transform[0, 0] = 0
    for i in range(total.shape[0]):
        for k in range(total.shape[1]):
            y = transform[i, k]
            total[i, k] += (y.real * y.real + y.imag * y.imag) * scale


@njit(cache=True, nogil=True)
def add_clipped(total, image, centre, reach):
    """The image less ``centre``, cut to +-reach, float32; it is added to ``total``.

    The image may be wider than ``total``, whose shape the result has.
    """
    out = np.empty(total.shape, np.float32)
    for i in range(total.shape[0]):
        source, target, sums = image[i], out[i], total[i]
        for j in range(target.size):
            y = min(max(source[j] - centre, -reach), reach)
            target[j] = y
            sums[j] += y
    return out


@njit(cache=True, nogil=True)
def reduce(power, index):
    """Sums over radial bins, over v != 0 at each u, over u != 0 at each v (the last u half).

    Each is (2, n): sums of the powers, and of their squares.
    """
    rows, half = power.shape
    radial = np.zeros((256, 2))
    by_u = np.zeros((2, half))
    by_v = np.zeros((2, rows))
    for i in range(1, rows):
        total, squares = 0.0, 0.0
        for k in range(1, half - 1):
            p = power[i, k]
            q = p * p
            radial[index[i, k], 0] += p
            radial[index[i, k], 1] += q
            by_u[0, k] += p
            by_u[1, k] += q
            total += p
            squares += q
        p = power[i, half - 1]
        radial[index[i, half - 1], 0] += 0.5 * p
        radial[index[i, half - 1], 1] += 0.5 * p * p
        by_u[0, half - 1] += p
        by_u[1, half - 1] += p * p
        by_v[0, i] = total + 0.5 * p
        by_v[1, i] = squares + 0.5 * p * p
    return radial.T, by_u, by_v


@njit(cache=True, nogil=True)
def search(power, columns, reach, guard, lowest):
    """Largest ratio, its row, column and floor, and the number of modes searched."""
    rows, half = power.shape
    cells = np.zeros(half)
    for d in range(-reach, reach + 1):
        if d != 0 and abs(d) > guard:
            for k in range(half):
                cells[k] += power[d % rows, k]
    best, best_i, best_k, best_floor, searched = 0.0, 0, 0, 0.0, 0
    for i in range(1, rows):
        inside = 2 * (reach - guard)
        # the window moves down by one row
        for k in range(half):
            cells[k] += power[(i + reach) % rows, k] - power[(i - 1 - reach) % rows, k]
            cells[k] += power[(i - 1 - guard) % rows, k] - power[(i + guard) % rows, k]
        near = min(i, rows - i)
        masked = guard < near <= reach  # the axis v = 0 lies in the window
        v = near / rows
        first = 1
        if v < lowest:
            first = max(1, math.ceil(math.sqrt(lowest * lowest - v * v) * columns))
        for k in range(first, half):
            low, high = max(1, k - 1), min(half - 1, k + 1)
            total = 0.0
            for m in range(low, high + 1):
                total += cells[m]
                if masked:
                    total -= power[0, m]
            floor = total / ((high - low + 1) * (inside - (1 if masked else 0)))
            searched += 1
            if power[i, k] > best * floor and floor > 0:
                best, best_i, best_k, best_floor = power[i, k] / floor, i, k, floor
    return best, best_i, best_k, best_floor, searched


@njit(cache=True, nogil=True)
def line_sums(image, centre, reach):
    """Sums of each column and of each row, and the sum of squares, float64.

    Of the float32 image less ``centre``, cut to +-reach.
    """
    by_column = np.zeros(image.shape[1])
    by_row = np.zeros(image.shape[0])
    square = 0.0
    total, squares = np.empty((2, LANES))
    for i in range(image.shape[0]):
        total[:] = 0
        squares[:] = 0
        for start in range(0, image.shape[1], LANES):
            part, sums = image[i, start : start + LANES], by_column[start : start + LANES]
            for j in range(part.size):
                y = np.float64(min(max(part[j] - centre, -reach), reach))
                sums[j] += y
                total[j] += y
                squares[j] += y * y
        by_row[i] = folded(total)
        square += folded(squares)
    return by_column, by_row, square


@njit(cache=True, nogil=True)
def block_waves(image, cosine, sine, blocks):
    """Sums of each row's blocks times a cosine and a sine, (rows, blocks, 2), float64."""
    rows = image.shape[0]
    width = image.shape[1] // blocks
    out = np.zeros((rows, blocks, 2))
    even, odd = np.empty((2, LANES), np.float32)
    for i in range(rows):
        for b in range(blocks):
            even[:] = 0
            odd[:] = 0
            for start in range(b * width, (b + 1) * width, LANES):
                stop = min(start + LANES, (b + 1) * width)
                part, c, s = image[i, start:stop], cosine[start:stop], sine[start:stop]
                for j in range(part.size):
                    even[j] += part[j] * c[j]
                    odd[j] += part[j] * s[j]
            out[i, b, 0] = folded(even)
            out[i, b, 1] = folded(odd)
    return out


@njit(cache=True, nogil=True)
def exceeds(power, down, across):
    """Whether down[s, i] across[s, k], summed over s, is more than each power; bool."""
    out = np.empty(power.shape, np.bool_)
    for i in range(power.shape[0]):
        for k in range(power.shape[1]):
            spread = down[0, i] * across[0, k] + down[1, i] * across[1, k]
            out[i, k] = spread > power[i, k]
    return out
