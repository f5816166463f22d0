"""Compiled loops of the streaming pass: single precision in, double precision sums out.

Serial and free of the GIL: the pass runs different accumulators in different threads, so results
do not depend on the number of threads. Nor do they depend on the processor: no operation is fused
or reordered, and a sum over pixels is the sum of `LANES` interleaved ones, which fill vectors of
any width in the same order.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from dnanalyze.analyzers.kernels.layout import BATCH

CHUNK = 4096  # pixels whose sums stay in the cache while a batch of frames goes over them
LANES = 64  # partial sums: a multiple of the elements of any vector
# Second differences share blocks: sum of their squared correlations, 1 + 2 (4/6)^2 + 2 (1/6)^2.
CURVATURE_OVERLAP = 35 / 18


@njit(nogil=True)
def _copy(source, target):
    for i in range(source.size):
        target[i] = source[i]


@njit(nogil=True)
def folded(lanes):
    """Sum of partial sums, in their order."""
    total = lanes[0]
    for j in range(1, lanes.size):
        total += lanes[j]
    return total


@njit(nogil=True)
def _frame_sums(y, past, centre, centre_before, cut, hot, lanes, out):
    """Sums over a stretch of a frame, see ``scalars`` of `add_frames`."""
    s1, s2, s11, s0 = lanes[0], lanes[1], lanes[2], lanes[3]
    lanes[:] = 0
    for i in range(0, y.size, LANES):
        here, before = y[i : i + LANES], past[i : i + LANES]
        for j in range(here.size):
            w = min(max(here[j] - centre, -cut), cut)
            x = min(max(before[j] - centre_before, -cut), cut)
            s0[j] += here[j] - centre
            s1[j] += w
            s2[j] += w * w
            s11[j] += w * x
    above, both = np.int32(0), np.int32(0)
    here_hot, before_hot = centre + hot, centre_before + hot
    for i in range(y.size):
        above = np.int32(above + (y[i] > here_hot))
        both = np.int32(both + ((y[i] > here_hot) & (past[i] > before_hot)))
    out[0] += folded(s1)
    out[1] += folded(s2)
    out[3] += above
    out[6] += folded(s0)
    if out[5] == 0:
        out[2] += folded(s11)
        out[4] += both


@njit(nogil=True)
def _pixel_sums(block, origin, total, square, lag):
    for i in range(total.size):
        before = np.float64(block[0, i]) - origin
        s, q, p = 0.0, 0.0, 0.0
        for k in range(1, BATCH + 1):
            v = np.float64(block[k, i]) - origin
            s += v
            q += v * v
            p += v * before
            before = v
        total[i] += s
        square[i] += q
        lag[i] += p


@njit(nogil=True)
def _extremes(block, number, high, high_at, low):
    for i in range(high.size):
        most, at, least = high[i], high_at[i], low[i]
        for k in range(1, BATCH + 1):
            y = block[k, i]
            more = y > most
            most = y if more else most
            at = np.int32(number + k - 1) if more else at
            least = y if y < least else least
        high[i] = most
        high_at[i] = at
        low[i] = least


@njit(nogil=True)
def _squares(y, past, limit, pairs):
    for i in range(y.size):
        d = np.float64(y[i]) - np.float64(past[i])
        pairs[i] += min(d * d, limit)


@njit(cache=True, nogil=True)
def add_frames(
    frames, count, number, before, origin, centres, limit, blink_limit, hot,
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
        The frame before them. Where there is none, that is where ``scalars[0, 5]`` is set, all
        ``origin``: its products are 0.
    origin : float
        Sums are of y less this, DN.
    centres : ndarray of float32
        Centre of the frame before and of each new one, DN.
    limit, hot : float
        Winsorise at ``centre +- limit``; pixels above ``centre + hot`` are counted. DN.
    blink_limit : float
        Squared differences are cut here, DN^2.
    total, square, lag, first_pairs, second_pairs : ndarray of float64
        Sums of y, y^2, y_n y_(n-1) (y less ``origin``), and of squared differences between frames
        4j and 4j+1, and 4j+2 and 4j+3.
    high, high_at, low : ndarray
        Largest value, its frame, smallest value.
    scalars : ndarray of float64
        A row for each frame: sum and sum of squares of the winsorised frame, its product with the
        one before, hot pixels, those that were so in the frame before; 1 where there is no
        frame before; the sum of the frame less its centre; and what is left to the caller.
    """
    n = total.size
    block = np.empty((BATCH + 1, CHUNK), np.float32)
    lanes = np.empty((4, LANES), np.float32)
    for start in range(0, n, CHUNK):
        stop = min(n, start + CHUNK)
        width = stop - start
        _copy(before[start:stop], block[0])
        for k in range(BATCH):  # a short batch is filled up with its last frame
            _copy(frames[min(k, count - 1)][start:stop], block[k + 1])
        _extremes(block, np.int32(number), high[start:stop], high_at[start:stop], low[start:stop])
        for k in range(count):
            y, past = block[k + 1, :width], block[k, :width]
            _frame_sums(
                y, past, centres[k + 1], centres[k], np.float32(limit), np.float32(hot), lanes,
                scalars[k],
            )  # fmt: skip
            if scalars[k, 5] == 0 and (number + k) % 4 == 1:
                _squares(y, past, blink_limit, first_pairs[start:stop])
            elif scalars[k, 5] == 0 and (number + k) % 4 == 3:
                _squares(y, past, blink_limit, second_pairs[start:stop])
        for k in range(count, BATCH):
            for i in range(width):
                block[k + 1, i] = origin  # adds nothing to sums
        _pixel_sums(block, origin, total[start:stop], square[start:stop], lag[start:stop])


@njit(cache=True, nogil=True)
def seam_sums(y, past, centre, centre_before, limit, hot, out):
    """The row of ``scalars`` of `add_frames` for a frame and the one before it, bit for bit."""
    out[:2] = 0
    out[3] = 0
    out[6] = 0
    lanes = np.empty((4, LANES), np.float32)
    for start in range(0, y.size, CHUNK):
        stop = min(y.size, start + CHUNK)
        _frame_sums(
            y[start:stop], past[start:stop], np.float32(centre), np.float32(centre_before),
            np.float32(limit), np.float32(hot), lanes, out,
        )  # fmt: skip


@njit(cache=True, nogil=True)
def cumulants(one, two, three, first, second, cut, out):
    """Sums over the pixels of the unbiased cumulants of three flat frames, float32: DN^2, DN^3.

    With the differences u of the first two frames and v of the last two, each less what the level
    moves (``first``, ``second``) and cut to +-``cut``: k2 = (u^2 + u v + v^2) / 3 and
    k3 = 3/2 sum (y - mean)^3 = (2 u + v)(v - u)(u + 2 v) / 6.
    """
    first, second, cut = np.float32(first), np.float32(second), np.float32(cut)
    twice, third, sixth = np.float32(2.0), np.float32(1.0 / 3.0), np.float32(1.0 / 6.0)
    lanes = np.empty((2, LANES), np.float32)
    k2, k3 = lanes[0], lanes[1]
    for start in range(0, one.size, CHUNK):
        stop = min(one.size, start + CHUNK)
        lanes[:] = 0
        for i in range(start, stop, LANES):
            a, b, c = one[i : i + LANES], two[i : i + LANES], three[i : i + LANES]
            for j in range(min(LANES, stop - i)):
                u = min(max(b[j] - a[j] - first, -cut), cut)
                v = min(max(c[j] - b[j] - second, -cut), cut)
                k2[j] += (u * u + u * v + v * v) * third
                k3[j] += (twice * u + v) * (v - u) * (u + twice * v) * sixth
        out[0] += folded(k2)
        out[1] += folded(k3)


@njit(cache=True, nogil=True)
def moments(total, square, lag, first, last, origin, count, mean, variance, lag_one):
    """Mean, unbiased variance and lag-one sum of each pixel from its sums, see `PixelMaps`."""
    k = np.float64(count)
    for i in range(total.size):
        t = total[i]
        m = t / k
        mean[i] = m + origin
        variance[i] = max(square[i] - t * t / k, 0.0) / max(k - 1.0, 1.0)
        ends = np.float64(first[i]) + np.float64(last[i]) - 2 * origin
        lag_one[i] = lag[i] - m * (2 * t - ends) + (k - 1.0) * m * m


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
def tally_lattice(values, first, step, levels, counts):
    """Count flat ``values`` that lie on a lattice from ``first``; False where they do not.

    ``levels`` takes the value of each point as it stands in the sample.
    """
    scale = 1.0 / step
    for i in range(values.size):
        x = values[i]
        k = np.int64((x - first) * scale + 0.5)
        if counts[k] == 0:
            levels[k] = x
        elif levels[k] != x:
            return False
        counts[k] += 1
    return True


@njit(nogil=True)
def _count_below(key, threshold):
    n = np.int32(0)
    for i in range(key.size):
        n += np.int32(key[i] < threshold)
    return n


@njit(cache=True, nogil=True)
def count_below(key, thresholds, row_edges, column_edges, counts):
    """Count in each block the pixels below each threshold.

    ``key`` is (rows, columns) float32, ``counts`` (row bands, column bands, thresholds) float64.
    """
    for a in range(row_edges.size - 1):
        for r in range(row_edges[a], row_edges[a + 1]):
            for b in range(column_edges.size - 1):
                part = key[r, column_edges[b] : column_edges[b + 1]]
                for k in range(thresholds.size):
                    counts[a, b, k] += _count_below(part, thresholds[k])


@njit(cache=True, nogil=True)
def sum_below(key, weight, thresholds, row_edges, column_edges, sums):
    """Sum ``weight`` in each block over the pixels whose key is below each threshold, and over all.

    As `count_below`; ``sums`` is (row bands, column bands, thresholds + 1).
    """
    last = thresholds.size
    width = 0
    for b in range(column_edges.size - 1):
        width = max(width, column_edges[b + 1] - column_edges[b])
    below = np.empty((last + 1, width))  # by threshold and column
    for a in range(row_edges.size - 1):
        for b in range(column_edges.size - 1):
            left, right = column_edges[b], column_edges[b + 1]
            below[:] = 0
            for r in range(row_edges[a], row_edges[a + 1]):
                part, keys = weight[r, left:right], key[r, left:right]
                _add(part, below[last])
                for k in range(last):
                    _add_below(keys, part, thresholds[k], below[k])
            for k in range(last + 1):
                sums[a, b, k] += folded(below[k, : right - left])


@njit(nogil=True)
def _add(weight, sums):
    for j in range(weight.size):
        sums[j] += np.float64(weight[j])


@njit(nogil=True)
def _add_below(key, weight, threshold, sums):
    for j in range(weight.size):
        sums[j] += np.float64(weight[j]) if key[j] < threshold else 0.0


@njit(cache=True, nogil=True)
def power_sums(values, centre):
    """Sums of the first eight powers of flat float32 ``values`` less ``centre``."""
    sums = np.zeros((8, LANES))
    s1, s2, s3, s4 = sums[0], sums[1], sums[2], sums[3]
    s5, s6, s7, s8 = sums[4], sums[5], sums[6], sums[7]
    for i in range(0, values.size, LANES):
        part = values[i : i + LANES]
        for j in range(part.size):
            d = np.float64(part[j]) - centre
            q = d * d
            r = q * q
            s1[j] += d
            s2[j] += q
            s3[j] += q * d
            s4[j] += r
            s5[j] += r * d
            s6[j] += r * q
            s7[j] += r * q * d
            s8[j] += r * r
    return (
        folded(s1), folded(s2), folded(s3), folded(s4),
        folded(s5), folded(s6), folded(s7), folded(s8),
    )  # fmt: skip


@njit(cache=True, nogil=True)
def products(a, b):
    """Sums of a, b, a^2, b^2 and a b over flat float32 arrays."""
    sums = np.zeros((5, LANES))
    sa, sb, saa, sbb, sab = sums[0], sums[1], sums[2], sums[3], sums[4]
    for i in range(0, a.size, LANES):
        left, right = a[i : i + LANES], b[i : i + LANES]
        for j in range(left.size):
            x, y = np.float64(left[j]), np.float64(right[j])
            sa[j] += x
            sb[j] += y
            saa[j] += x * x
            sbb[j] += y * y
            sab[j] += x * y
    return folded(sa), folded(sb), folded(saa), folded(sbb), folded(sab)


@njit(cache=True, nogil=True)
def pair_products(values, out):
    """Products of neighbours in a map, about the means of its rows and columns.

    ``out`` (bands of rows, 5) gets the sums over the pairs of columns (0, 1), (2, 3), ..., over
    those of (1, 2), (3, 4), ..., over the pairs of rows alike, and over pixels with themselves.
    """
    rows, columns = values.shape
    down, along, mean = np.zeros(columns), np.zeros(rows), 0.0
    for r in range(rows):
        for c in range(columns):
            along[r] += values[r, c]
            down[c] += values[r, c]
    for r in range(rows):
        mean += along[r] / (rows * columns)
        along[r] /= columns
    down /= rows
    above, here = np.zeros(columns), np.zeros(columns)
    out[:] = 0.0
    for r in range(rows):
        band = out[r * out.shape[0] // rows]
        for c in range(columns):
            here[c] = values[r, c] - along[r] - down[c] + mean
            band[4] += here[c] * here[c]
            if r:
                band[2 + (r + 1) % 2] += above[c] * here[c]
        for c in range(1, columns):
            band[(c + 1) % 2] += here[c - 1] * here[c]
        above, here = here, above


@njit(cache=True, nogil=True)
def block_covariance(a, b, out):
    """Covariance of two sums over blocks, from their parts (row bands, column bands, k).

    ``out`` (3, k) gets the covariance from single blocks, what row and column bands add to it,
    and the variance of the first where the two are independent.

    Blocks are compared with their neighbours: the second difference along both axes leaves out what
    a row band or a column band has as a whole, and the fourth difference of bands what varies
    slowly over them. Structure of the field, such as glow or shading, is therefore no scatter. Of
    fewer than 5 bands along an axis the mean alone is taken off.
    """
    rows, columns, count = a.shape
    for k in range(count):
        each, chance, added = 0.0, 0.0, 0.0
        if rows > 4 and columns > 4:
            for r in range(1, rows - 1):
                for c in range(1, columns - 1):
                    left = _curvature(a[r - 1, c - 1, k], a[r - 1, c, k], a[r - 1, c + 1, k])
                    left -= 2 * _curvature(a[r, c - 1, k], a[r, c, k], a[r, c + 1, k])
                    left += _curvature(a[r + 1, c - 1, k], a[r + 1, c, k], a[r + 1, c + 1, k])
                    right = _curvature(b[r - 1, c - 1, k], b[r - 1, c, k], b[r - 1, c + 1, k])
                    right -= 2 * _curvature(b[r, c - 1, k], b[r, c, k], b[r, c + 1, k])
                    right += _curvature(b[r + 1, c - 1, k], b[r + 1, c, k], b[r + 1, c + 1, k])
                    product = left * right / 36
                    each += product
                    chance += product * product
            scale = rows * columns / ((rows - 2) * (columns - 2))
            each *= scale
            chance *= scale * scale * CURVATURE_OVERLAP * CURVATURE_OVERLAP
        else:
            for r in range(rows):
                for c in range(columns):
                    product = a[r, c, k] * b[r, c, k]
                    each += product
                    chance += product * product
            each *= rows * columns / max(rows * columns - 1, 1)
        if rows > 4 and columns > 4:
            added = _band_covariance(a[:, :, k], b[:, :, k])
            added += _band_covariance(a[:, :, k].T, b[:, :, k].T) - 2 * each
        out[0, k] = each
        out[1, k] = added
        out[2, k] = chance


@njit(nogil=True)
def _curvature(before, here, after):
    return before - 2 * here + after


@njit(nogil=True)
def _band_covariance(a, b):
    """Covariance of the sum over row bands, from the fourth differences of their sums."""
    bands, across = a.shape
    left, right = np.zeros(bands), np.zeros(bands)
    for i in range(bands):
        for j in range(across):
            left[i] += a[i, j]
            right[i] += b[i, j]
    total = 0.0
    for i in range(2, bands - 2):
        one = left[i - 2] - 4 * left[i - 1] + 6 * left[i] - 4 * left[i + 1] + left[i + 2]
        other = right[i - 2] - 4 * right[i - 1] + 6 * right[i] - 4 * right[i + 1] + right[i + 2]
        total += one * other / 70
    return total * bands / (bands - 4)
