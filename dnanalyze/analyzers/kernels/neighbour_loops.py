"""Compiled loops over pixels and their neighbours: single precision in, double precision sums out.

Each works row by row and sums down the rows of a band, so that whole vectors are filled, then adds
up the columns of each block. ``out`` is (row bands, column bands, sums), float64, and is added to.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from dnanalyze.analyzers.kernels.layout import (
    PEAK_EXCESS,
    PEAK_SUMS,
    PEAK_TIES,
    PEAK_TOP,
    RANK_HIGH,
    RANK_LOW,
    RANK_PIXELS,
    RANK_SUMS,
    TILE,
)
from dnanalyze.analyzers.kernels.pixel_loops import LANES, folded


@njit(nogil=True, inline="always")
def _rank_row(above, here, below, most, least, high, low, gap):
    """For one row: the pixel's share in being highest, and lowest, of 9; and its lead over the 8.

    Pixels that tie for the place share it evenly, which is what a dither would give on average.
    ``most`` and ``least`` are room for the extremes of three; the result has no border pixels.
    """
    one = np.float32(1.0)
    zero = np.float32(0.0)
    n = here.size - 2
    for j in range(here.size):
        most[j] = max(max(above[j], below[j]), here[j])
        least[j] = min(min(above[j], below[j]), here[j])
    a, b, c = above[:n], above[1:-1], above[2:]
    d, y, e = here[:n], here[1:-1], here[2:]
    f, g, h = below[:n], below[1:-1], below[2:]
    most_left, most_right = most[:n], most[2:]
    least_left, least_right = least[:n], least[2:]
    for j in range(n):
        v = y[j]
        top = max(max(most_left[j], most_right[j]), max(b[j], g[j]))
        bottom = min(min(least_left[j], least_right[j]), min(b[j], g[j]))
        alike = np.int32(a[j] == v) + np.int32(b[j] == v) + np.int32(c[j] == v)
        alike += np.int32(d[j] == v) + np.int32(e[j] == v)
        alike += np.int32(f[j] == v) + np.int32(g[j] == v) + np.int32(h[j] == v)
        count = np.int32(1 + alike)  # not 64 bits, which fill no vectors
        share = one / np.float32(count)
        high[j] = share if v >= top else zero
        low[j] = share if v <= bottom else zero
        gap[j] = v - top


@njit(nogil=True)
def _into_bands(columns, column_edges, first, out):
    """Add sums by column, (sums, columns) from column ``first`` on, to their bands."""
    for c in range(column_edges.size - 1):
        left = max(0, column_edges[c] - first)
        right = min(columns.shape[1], column_edges[c + 1] - first)
        for k in range(columns.shape[0]):
            total = 0.0
            for j in range(left, right):
                total += columns[k, j]
            out[c, k] += total


@njit(cache=True, nogil=True)
def rank_sums(x, row_edges, column_edges, out):
    """Pixels, shares in being above, and below, all 8 neighbours; border pixels are left out."""
    rows, columns = x.shape
    most, least = np.empty((2, columns), np.float32)
    high, low, gap = np.empty((3, columns - 2), np.float32)
    sums = np.empty((RANK_SUMS, columns - 2), np.float32)
    for r in range(row_edges.size - 1):
        first, last = max(1, row_edges[r]), min(rows - 1, row_edges[r + 1])
        sums[:] = 0
        sums[RANK_PIXELS] = last - first
        sum_high, sum_low = sums[RANK_HIGH], sums[RANK_LOW]
        for i in range(first, last):
            _rank_row(x[i - 1], x[i], x[i + 1], most, least, high, low, gap)
            for j in range(high.size):
                sum_high[j] += high[j]
                sum_low[j] += low[j]
        _into_bands(sums, column_edges, 1, out[r])


@njit(cache=True, nogil=True)
def peak_sums(x, top, share, leads, widths, row_edges, column_edges, out):
    """As `rank_sums`, and more of single frames.

    Pixels above ``top``, those at ``top`` counted as ``share``; those of them that equal their
    highest neighbour; pixels that lead all neighbours by more than each of the three ``leads``, DN,
    those within half of its ``widths`` of it in part.
    """
    rows, columns = x.shape
    most, least = np.empty((2, columns), np.float32)
    high, low, gap = np.empty((3, columns - 2), np.float32)
    sums = np.empty((PEAK_SUMS, columns - 2), np.float32)
    zero, one = np.float32(0.0), np.float32(1.0)
    limit, part = np.float32(top), np.float32(share)
    half = np.float32(0.5)
    k0, k1, k2 = np.float32(leads[0]), np.float32(leads[1]), np.float32(leads[2])
    w0, w1, w2 = np.float32(widths[0]), np.float32(widths[1]), np.float32(widths[2])
    for r in range(row_edges.size - 1):
        first, last = max(1, row_edges[r]), min(rows - 1, row_edges[r + 1])
        sums[:] = 0
        sums[RANK_PIXELS] = last - first
        sum_high, sum_low, tops = sums[RANK_HIGH], sums[RANK_LOW], sums[PEAK_TOP]
        ties, lead0 = sums[PEAK_TIES], sums[PEAK_EXCESS]
        lead1, lead2 = sums[PEAK_EXCESS + 1], sums[PEAK_EXCESS + 2]
        for i in range(first, last):
            here = x[i, 1:-1]
            _rank_row(x[i - 1], x[i], x[i + 1], most, least, high, low, gap)
            for j in range(high.size):
                sum_high[j] += high[j]
                sum_low[j] += low[j]
                weight = part if here[j] == limit else zero
                weight = one if here[j] > limit else weight
                tops[j] += weight
                ties[j] += weight if gap[j] == zero else zero
            for j in range(high.size):
                lead0[j] += min(max((gap[j] - k0) / w0 + half, zero), one)
                lead1[j] += min(max((gap[j] - k1) / w1 + half, zero), one)
                lead2[j] += min(max((gap[j] - k2) / w2 + half, zero), one)
        _into_bands(sums, column_edges, 1, out[r])


@njit(cache=True, nogil=True)
def line_means(x, reach):
    """Means of the rows and of the columns of ``x`` cut to +-reach, float32."""
    rows, columns = x.shape
    cut = np.float32(reach)
    by_row = np.empty(rows, np.float32)
    by_column = np.zeros(columns)
    total = np.empty(LANES, np.float32)
    for i in range(rows):
        total[:] = 0
        for start in range(0, columns, LANES):
            part, sums = x[i, start : start + LANES], by_column[start : start + LANES]
            for j in range(part.size):
                y = min(max(part[j], -cut), cut)
                total[j] += y
                sums[j] += y
        by_row[i] = folded(total) / np.float32(columns)
    return by_row, (by_column / rows).astype(np.float32)


@njit(nogil=True, inline="always")
def _residual_row(x, shift, by_column, cut, out):
    for j in range(x.size):
        out[j] = min(max(x[j], -cut), cut) - shift - by_column[j]


@njit(nogil=True, inline="always")
def _add_products(buffer, i, sums):
    """Those of row i at the `LAGS`; ``buffer`` holds it and the two rows after it in turn."""
    columns = sums.shape[1]
    half = np.float32(0.5)
    here, next_row = buffer[i % 3], buffer[(i + 1) % 3]
    a, a1, a2 = here[:columns], here[1 : columns + 1], here[2:]
    b, b1 = next_row[:columns], next_row[1 : columns + 1]
    c = buffer[(i + 2) % 3, :columns]
    s00, s10, s01, s11, s20, s02 = sums[0], sums[1], sums[2], sums[3], sums[4], sums[5]
    for j in range(columns):
        y = a[j]
        s00[j] += y * y
        s10[j] += y * a1[j]
        s20[j] += y * a2[j]
        s01[j] += y * b[j]
        s02[j] += y * c[j]
        s11[j] += half * (y * b1[j] + a1[j] * b[j])


@njit(cache=True, nogil=True)
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
    sums = np.empty((6, columns), np.float32)
    for r in range(row_edges.size - 1):
        sums[:] = zero
        for i in range(row_edges[r], row_edges[r + 1]):
            if i + 2 < rows:
                _residual_row(x[i + 2], by_row[i + 2] - middle, by_column, cut, buffer[(i + 2) % 3])
            else:
                buffer[(i + 2) % 3, :] = zero
            _add_products(buffer, i, sums)
        _into_bands(sums, column_edges, 0, out[r])


@njit(cache=True, nogil=True)
def inner_sums(x, reach, by_row, by_column, row_edges, column_edges, out):
    """As `lag_sums`, of the pixels within +-reach alone, and their number: (bands, bands, 7)."""
    rows, columns = x.shape
    cut = np.float32(reach)
    middle = np.float32(by_row.mean())
    zero, one = np.float32(0.0), np.float32(1.0)
    buffer = np.zeros((3, columns + 2), np.float32)
    inside = np.zeros((3, columns), np.float32)
    sums = np.empty((7, columns), np.float32)
    for r in range(row_edges.size - 1):
        sums[:] = zero
        for i in range(row_edges[r], row_edges[r + 1]):
            for ahead in range(0 if i == 0 else 2, 3):
                made = buffer[(i + ahead) % 3]
                if i + ahead >= rows:
                    made[:] = zero
                    continue
                line, kept = x[i + ahead], inside[(i + ahead) % 3]
                shift = by_row[i + ahead] - middle
                for j in range(columns):
                    kept[j] = one if abs(line[j]) <= cut else zero
                    made[j] = kept[j] * (line[j] - shift - by_column[j])
            counted = inside[i % 3]
            _add_products(buffer, i, sums)
            for j in range(columns):
                sums[6, j] += counted[j]
        _into_bands(sums, column_edges, 0, out[r])


@njit(cache=True, nogil=True)
def tile_sums(x, reach, row_band, column_band, out):
    """Variances of 4x4 tiles and the diagonal Haar band of ``x`` cut to +-reach.

    Tile by tile: count, sum of the unbiased variances, sum of their squares; Haar coefficients, sum
    of their squares and fourth powers. ``row_band`` and ``column_band`` name each line's band.
    """
    rows, columns = x.shape
    cut = np.float32(reach)
    half = np.float32(0.5)
    total, square = np.empty((2, columns), np.float32)
    across = np.zeros(columns + 1, np.float32)
    second, fourth = np.empty((2, columns), np.float32)
    next_to = across[1:]
    for i in range(0, rows - TILE + 1, TILE):
        total[:] = 0
        square[:] = 0
        second[:] = 0
        fourth[:] = 0
        for m in range(0, TILE, 2):
            upper, lower = x[i + m], x[i + m + 1]
            for j in range(columns):
                a = min(max(upper[j], -cut), cut)
                b = min(max(lower[j], -cut), cut)
                total[j] += a + b
                square[j] += a * a + b * b
                across[j] = half * (a - b)
            for j in range(columns):  # those of odd columns are not used
                h = across[j] - next_to[j]
                h *= h
                second[j] += h
                fourth[j] += h * h
        sums = out[row_band[i]]
        for j in range(0, columns - TILE + 1, TILE):
            s = total[j] + total[j + 1] + total[j + 2] + total[j + 3]
            q = square[j] + square[j + 1] + square[j + 2] + square[j + 3]
            variance = max(np.float64(q) - np.float64(s) * s / 16.0, 0.0) / 15.0
            k = column_band[j]
            sums[k, 0] += 1.0
            sums[k, 1] += variance
            sums[k, 2] += variance * variance
            sums[k, 3] += 4.0
            sums[k, 4] += second[j] + second[j + 2]
            sums[k, 5] += fourth[j] + fourth[j + 2]
