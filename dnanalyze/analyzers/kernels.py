"""Compiled loops of the streaming pass: single precision in, double precision sums out.

Serial and free of the GIL: the pass runs different accumulators in different threads, so results do not
depend on the number of threads.
"""

from __future__ import annotations

import numpy as np
from numba import njit

CHUNK = 4096  # pixels whose sums stay in the cache while a batch of frames goes over them


@njit(cache=True, nogil=True, fastmath={"contract", "nsz", "reassoc"})
def add_frames(
    frames, count, number, before, origin, centre, limit, blink_limit, hot,
    total, square, lag, first_pairs, second_pairs, high, high_at, low, scalars,
):  # fmt: skip
    """Add a batch of frames to the sums of each pixel.

    Parameters
    ----------
    frames : tuple of ndarray of float32
        Flat frames, DN; the first ``count`` of them are new.
    number : int
        Number of the first of them in the setting.
    before : ndarray of float32
        The frame before them; not read where ``number`` is the first frame of this accumulator,
        that is where ``scalars[0, 5]`` is set.
    origin : float
        Sums are of y less this, DN.
    centre, limit, hot : float
        Winsorise at ``centre +- limit``; pixels above ``hot`` are counted. DN.
    blink_limit : float
        Squared differences are cut here, DN^2.
    total, square, lag, first_pairs, second_pairs : ndarray of float64
        Sums of y, y^2, y_n y_(n-1) (y less ``origin``), and of squared differences between frames
        4j and 4j+1, and 4j+2 and 4j+3.
    high, high_at, low : ndarray
        Largest value, its frame, smallest value.
    scalars : ndarray of float64
        A row for each frame: sum and sum of squares of the winsorised frame, its product with the
        one before, pixels above ``hot``, those that were so in the frame before; and 1 where
        there is no frame before.
    """
    n = total.size
    c = np.float32(centre)
    cut = np.float32(limit)
    edge = np.float32(hot)
    for start in range(0, n, CHUNK):
        stop = min(n, start + CHUNK)
        for k in range(count):
            y = frames[k]
            alone = scalars[k, 5] > 0
            past = y if alone else (before if k == 0 else frames[k - 1])
            s1, s2, s11 = 0.0, 0.0, 0.0
            above, both = 0, 0
            for i in range(start, stop):
                v = y[i] - c
                w = min(max(v, -cut), cut)
                x = min(max(past[i] - c, -cut), cut)
                s1 += w
                s2 += np.float64(w) * w
                s11 += np.float64(w) * x
                above += y[i] > edge
                both += (y[i] > edge) & (past[i] > edge)
            scalars[k, 0] += s1
            scalars[k, 1] += s2
            scalars[k, 3] += above
            if not alone:
                scalars[k, 2] += s11
                scalars[k, 4] += both
            for i in range(start, stop):
                v = np.float64(y[i]) - origin
                total[i] += v
                square[i] += v * v
            if not alone:
                for i in range(start, stop):
                    lag[i] += (np.float64(y[i]) - origin) * (np.float64(past[i]) - origin)
            at = np.int32(number + k)
            for i in range(start, stop):
                more = y[i] > high[i]
                high[i] = y[i] if more else high[i]
                high_at[i] = at if more else high_at[i]
                low[i] = min(y[i], low[i])
            if not alone and at % 2 == 1:
                pairs = first_pairs if at % 4 == 1 else second_pairs
                for i in range(start, stop):
                    d = np.float64(y[i]) - np.float64(past[i])
                    pairs[i] += min(d * d, blink_limit)


@njit(cache=True, nogil=True)
def tally(values, first, width, counts):
    """Count flat float32 ``values`` in equal bins; ``first`` is the centre of the first.

    ``counts`` has four rows, so that like values in turn do not wait for one another; what lies
    outside goes into the end bins.
    """
    last = counts.shape[1] - 1
    scale = np.float32(1.0 / width)
    shift = np.float32(0.5 - first / width)
    n = values.size
    whole = n - n % 4
    for i in range(0, whole, 4):
        for j in range(4):
            k = np.int64(values[i + j] * scale + shift)
            counts[j, min(max(k, 0), last)] += 1
    for i in range(whole, n):
        k = np.int64(values[i] * scale + shift)
        counts[0, min(max(k, 0), last)] += 1


@njit(cache=True, nogil=True)
def grouped(key, weight, thresholds, row_edges, column_edges, counts, sums):
    """Count pixels and sum ``weight`` in each block, in groups of ``key`` between the thresholds.

    ``key`` and ``weight`` are (rows, columns) float32, ``counts`` and ``sums`` are (row bands,
    column bands, thresholds + 1) float64. Group g holds thresholds[g-1] <= key < thresholds[g].
    """
    for a in range(row_edges.size - 1):
        for r in range(row_edges[a], row_edges[a + 1]):
            for b in range(column_edges.size - 1):
                for c in range(column_edges[b], column_edges[b + 1]):
                    g = 0
                    for t in thresholds:
                        g += key[r, c] >= t
                    counts[a, b, g] += 1
                    sums[a, b, g] += weight[r, c]


@njit(cache=True, nogil=True, fastmath={"contract", "nsz", "reassoc"})
def power_sums(values, centre):
    """Sums of the first eight powers of flat float32 ``values`` less ``centre``."""
    s1, s2, s3, s4, s5, s6, s7, s8 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for v in values:
        d = np.float64(v) - centre
        q = d * d
        r = q * q
        s1 += d
        s2 += q
        s3 += q * d
        s4 += r
        s5 += r * d
        s6 += r * q
        s7 += r * q * d
        s8 += r * r
    return s1, s2, s3, s4, s5, s6, s7, s8
