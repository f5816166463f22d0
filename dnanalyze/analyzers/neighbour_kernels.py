"""Compiled loops over pixels and their neighbours: single precision in, double precision sums out.

Each works row by row on buffers that stay in the first-level cache, then adds up the segments of
the block grid. ``out`` is (row bands, column bands, sums), float64, and is added to.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from dnanalyze.analyzers.neighbours_accumulator import (
    PEAK_EXCESS,
    PEAK_TIES,
    PEAK_TOP,
    RANK_HIGH,
    RANK_LOW,
    RANK_PIXELS,
    TILE,
)

_FAST = {"contract", "nsz", "reassoc", "arcp"}


@njit(nogil=True, fastmath=_FAST, inline="always")
def _rank_row(above, here, below, high, low, gap):
    """For one row: the pixel's share in being highest, and lowest, of 9; and its lead over the 8.

    Pixels that tie for the place share it evenly, which is what a dither would give on average.
    """
    one = np.float32(1.0)
    zero = np.float32(0.0)
    for j in range(1, here.size - 1):
        y = here[j]
        a, b, c = above[j - 1], above[j], above[j + 1]
        d, e = here[j - 1], here[j + 1]
        f, g, h = below[j - 1], below[j], below[j + 1]
        top = max(max(max(a, b), max(c, d)), max(max(e, f), max(g, h)))
        bottom = min(min(min(a, b), min(c, d)), min(min(e, f), min(g, h)))
        alike = np.int32(a == y) + np.int32(b == y) + np.int32(c == y) + np.int32(d == y)
        alike += np.int32(e == y) + np.int32(f == y) + np.int32(g == y) + np.int32(h == y)
        share = one / np.float32(1 + alike)
        high[j] = share if y >= top else zero
        low[j] = share if y <= bottom else zero
        gap[j] = y - top


@njit(cache=True, nogil=True, fastmath=_FAST)
def rank_sums(x, row_edges, column_edges, out):
    """Pixels, shares in being above, and below, all 8 neighbours; border pixels are left out."""
    rows, columns = x.shape
    high, low, gap = np.empty((3, columns), np.float32)
    for r in range(row_edges.size - 1):
        for i in range(max(1, row_edges[r]), min(rows - 1, row_edges[r + 1])):
            _rank_row(x[i - 1], x[i], x[i + 1], high, low, gap)
            for c in range(column_edges.size - 1):
                first, last = max(1, column_edges[c]), min(columns - 1, column_edges[c + 1])
                s_high, s_low = np.float32(0.0), np.float32(0.0)
                for j in range(first, last):
                    s_high += high[j]
                    s_low += low[j]
                out[r, c, RANK_PIXELS] += max(0, last - first)
                out[r, c, RANK_HIGH] += s_high
                out[r, c, RANK_LOW] += s_low


@njit(cache=True, nogil=True, fastmath=_FAST)
def peak_sums(x, top, share, leads, row_edges, column_edges, out):
    """As `rank_sums`, and more of single frames.

    Pixels above ``top``, those at ``top`` counted as ``share``; those of them that equal their
    highest neighbour; pixels that lead all neighbours by more than each of the three ``leads``, DN.
    """
    rows, columns = x.shape
    high, low, gap = np.empty((3, columns), np.float32)
    zero, one = np.float32(0.0), np.float32(1.0)
    limit, part = np.float32(top), np.float32(share)
    k0, k1, k2 = np.float32(leads[0]), np.float32(leads[1]), np.float32(leads[2])
    for r in range(row_edges.size - 1):
        for i in range(max(1, row_edges[r]), min(rows - 1, row_edges[r + 1])):
            here = x[i]
            _rank_row(x[i - 1], here, x[i + 1], high, low, gap)
            for c in range(column_edges.size - 1):
                first, last = max(1, column_edges[c]), min(columns - 1, column_edges[c + 1])
                s_high, s_low = zero, zero
                n_top, n_ties = zero, zero
                n0, n1, n2 = 0, 0, 0
                for j in range(first, last):
                    s_high += high[j]
                    s_low += low[j]
                    weight = part if here[j] == limit else zero
                    weight = one if here[j] > limit else weight
                    n_top += weight
                    n_ties += weight if gap[j] == zero else zero
                    n0 += gap[j] > k0
                    n1 += gap[j] > k1
                    n2 += gap[j] > k2
                out[r, c, RANK_PIXELS] += max(0, last - first)
                out[r, c, RANK_HIGH] += s_high
                out[r, c, RANK_LOW] += s_low
                out[r, c, PEAK_TOP] += n_top
                out[r, c, PEAK_TIES] += n_ties
                out[r, c, PEAK_EXCESS] += n0
                out[r, c, PEAK_EXCESS + 1] += n1
                out[r, c, PEAK_EXCESS + 2] += n2


@njit(cache=True, nogil=True, fastmath=_FAST)
def line_means(x, reach):
    """Means of the rows and of the columns of ``x`` cut to +-reach, float32."""
    rows, columns = x.shape
    cut = np.float32(reach)
    by_row = np.empty(rows, np.float32)
    by_column = np.zeros(columns)
    for i in range(rows):
        total = np.float32(0.0)
        for j in range(columns):
            y = min(max(x[i, j], -cut), cut)
            total += y
            by_column[j] += y
        by_row[i] = total / np.float32(columns)
    return by_row, (by_column / rows).astype(np.float32)


@njit(nogil=True, fastmath=_FAST, inline="always")
def _residual_row(x, shift, by_column, cut, out):
    for j in range(x.size):
        out[j] = min(max(x[j], -cut), cut) - shift - by_column[j]


@njit(cache=True, nogil=True, fastmath=_FAST)
def lag_sums(x, reach, by_row, by_column, row_edges, column_edges, out):
    """Sums of products at the `LAGS` of ``x`` cut to +-reach, less its row and column means.

    ``out`` is (row bands, column bands, 6). A pair belongs to the block of its first pixel.
    """
    rows, columns = x.shape
    cut = np.float32(reach)
    middle = np.float32(by_row.mean())
    buffer = np.zeros((3, columns + 2), np.float32)
    ahead = min(2, rows)
    for i in range(ahead):
        _residual_row(x[i], by_row[i] - middle, by_column, cut, buffer[i])
    zero = np.float32(0.0)
    half = np.float32(0.5)
    for r in range(row_edges.size - 1):
        for i in range(row_edges[r], row_edges[r + 1]):
            if i + 2 < rows:
                _residual_row(x[i + 2], by_row[i + 2] - middle, by_column, cut, buffer[(i + 2) % 3])
            else:
                buffer[(i + 2) % 3, :] = zero
            a, b, c = buffer[i % 3], buffer[(i + 1) % 3], buffer[(i + 2) % 3]
            for k in range(column_edges.size - 1):
                first, last = column_edges[k], column_edges[k + 1]
                s00, s10, s01, s11, s20, s02 = zero, zero, zero, zero, zero, zero
                for j in range(first, last):
                    y = a[j]
                    s00 += y * y
                    s10 += y * a[j + 1]
                    s20 += y * a[j + 2]
                    s01 += y * b[j]
                    s02 += y * c[j]
                    s11 += half * (y * b[j + 1] + a[j + 1] * b[j])
                out[r, k, 0] += s00
                out[r, k, 1] += s10
                out[r, k, 2] += s01
                out[r, k, 3] += s11
                out[r, k, 4] += s20
                out[r, k, 5] += s02


@njit(cache=True, nogil=True, fastmath=_FAST)
def tile_sums(x, reach, row_band, column_band, out):
    """Variances of 4x4 tiles and the diagonal Haar band of ``x`` cut to +-reach.

    Tile by tile: count, sum of the unbiased variances, sum of their squares; Haar coefficients, sum
    of their squares and fourth powers. ``row_band`` and ``column_band`` name each line's band.
    """
    rows, columns = x.shape
    cut = np.float32(reach)
    half = np.float32(0.5)
    for i in range(0, rows - TILE + 1, TILE):
        for j in range(0, columns - TILE + 1, TILE):
            s, q, h2, h4 = np.float32(0.0), np.float32(0.0), np.float32(0.0), np.float32(0.0)
            for m in range(0, TILE, 2):
                for n in range(0, TILE, 2):
                    a = min(max(x[i + m, j + n], -cut), cut)
                    b = min(max(x[i + m, j + n + 1], -cut), cut)
                    c = min(max(x[i + m + 1, j + n], -cut), cut)
                    d = min(max(x[i + m + 1, j + n + 1], -cut), cut)
                    s += a + b + c + d
                    q += a * a + b * b + c * c + d * d
                    h = half * (a - b - c + d)
                    h *= h
                    h2 += h
                    h4 += h * h
            variance = max(np.float64(q) - np.float64(s) * s / 16.0, 0.0) / 15.0
            r, k = row_band[i], column_band[j]
            out[r, k, 0] += 1.0
            out[r, k, 1] += variance
            out[r, k, 2] += variance * variance
            out[r, k, 3] += 4.0
            out[r, k, 4] += h2
            out[r, k, 5] += h4
