"""Compiled loops over pixels: random numbers, counts, and what simulation spends its time in.

No fused multiply-add and no library logarithm: every operation is rounded as IEEE 754 says, so
the same key gives the same bits on every machine. Branch-free, to fill whole vectors.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

F = np.float32
U = np.uint64
_GOLDEN, _MIX1, _MIX2 = U(0x9E3779B97F4A7C15), U(0xBF58476D1CE4E5B9), U(0x94D049BB133111EB)
_S27, _S30, _S31, _S32 = U(27), U(30), U(31), U(32)
_SIGN, _TOP = np.int32(-(2**31)), np.int32(2**31 - 1)
_HALF, _ONE, _TWO = F(0.5), F(1), F(2)
_SQRT_HALF_BITS, _MANTISSA, _SHIFT = np.int32(0x3F3504F3), np.int32(0x7FFFFF), np.int32(23)
_LN2 = F(0.6931471805599453)

# log(1 + m)/m for 1 + m in sqrt(1/2) to sqrt(2), error of the product 4e-8 (weighted least squares)
_L0, _L1, _L2, _L3, _L4, _L5, _L6, _L7 = map(F, (
    0.9999998211860657, -0.5000066757202148, 0.33336180448532104, -0.24959343671798706,
    0.1987304836511612, -0.17333471775054932, 0.16419975459575653, -0.10102200508117676,
))  # fmt: skip

_compiled = njit(nogil=True, cache=True, error_model="numpy")
_inlined = njit(inline="always", error_model="numpy")


@intrinsic
def _bits_of_float(typing, x):
    """The bits of a float32 as int32."""

    def generate(context, builder, signature, args):
        return builder.bitcast(args[0], ir.IntType(32))

    return types.int32(types.float32), generate


@intrinsic
def _float_of_bits(typing, x):
    """The float32 of the bits of an int32."""

    def generate(context, builder, signature, args):
        return builder.bitcast(args[0], ir.FloatType())

    return types.float32(types.int32), generate


_as_int: Any = _bits_of_float
_as_float: Any = _float_of_bits


@_inlined
def _mix(z):
    """SplitMix64 finaliser (Steele, Lea and Flood, OOPSLA 2014): 64 bits to 64 well-mixed bits."""
    z = (z ^ (z >> _S30)) * _MIX1
    z = (z ^ (z >> _S27)) * _MIX2
    return z ^ (z >> _S31)


@_inlined
def _log(v):
    """Natural logarithm of a positive normal float32, absolute error < 2e-6 down to 1e-10."""
    i = _as_int(v) - _SQRT_HALF_BITS
    m = _as_float((i & _MANTISSA) + _SQRT_HALF_BITS) - _ONE
    p = _L7 * m + _L6
    p = p * m + _L5
    p = p * m + _L4
    p = p * m + _L3
    p = p * m + _L2
    p = p * m + _L1
    p = p * m + _L0
    return F(i >> _SHIFT) * _LN2 + p * m


# z/x as a polynomial in A - B/(w + 10), x = 2u - 1, w = -log(1 - x^2); error of z 1.1e-7 before
# rounding, for all 32-bit u (weighted least squares towards the minimax)
_A, _B, _C = F(1.930770993232727), F(29.307710647583008), F(10)
_Z0, _Z1, _Z2, _Z3, _Z4, _Z5, _Z6, _Z7, _Z8, _Z9, _Z10, _Z11, _Z12 = map(F, (
    2.9951517581939697, 2.347184419631958, 0.5876625180244446, 0.09259991347789764,
    0.23363545536994934, 0.09295359253883362, -0.06048748269677162, 0.006783090531826019,
    0.05257555842399597, 0.0007386205834336579, -0.017163332551717758,
    0.0020622294396162033, 0.00426151417195797,
))  # fmt: skip
_UNIT = F(2.0**-31)
_TINY, _BELOW_ONE = F(2.0**-32), F(1 - 2.0**-24)


@_inlined
def _normal(word):
    """Inverse of the normal distribution function at (word + 1/2) / 2^32, word as signed 32 bits.

    From x = 2u - 1 and q = 1 - |x|, both exact in the tails; |z| reaches 6.33.
    """
    b = word ^ _SIGN
    x = (F(b) + _HALF) * _UNIT
    q = (F(_TOP - (b ^ (b >> np.int32(31)))) + _HALF) * _UNIT
    w = -_log(q * (_TWO - q))
    t = _A - _B / (w + _C)
    p = _Z12 * t + _Z11
    p = p * t + _Z10
    p = p * t + _Z9
    p = p * t + _Z8
    p = p * t + _Z7
    p = p * t + _Z6
    p = p * t + _Z5
    p = p * t + _Z4
    p = p * t + _Z3
    p = p * t + _Z2
    p = p * t + _Z1
    p = p * t + _Z0
    return x * p


@_inlined
def _row_of_words(key, row, left, width, words):
    """Fill ``words`` (int32) with the random words of one row from column ``left`` on."""
    start = key + (U(row) * U(width) + U(left) + U(1)) * _GOLDEN
    for c in range(words.size):
        words[c] = np.int32(_mix(start + U(c) * _GOLDEN) >> _S32)


@_compiled
def fill_bits(key, top, left, width, out):
    """Random words, int32, of the window that ``out`` covers."""
    for r in range(out.shape[0]):
        _row_of_words(key, top + r, left, width, out[r])


@_compiled
def fill_uniform(key, top, left, width, out):
    """Uniform deviates, float32, with full relative precision towards 0 and never 1."""
    words = np.empty(out.shape[1], np.int32)
    for r in range(out.shape[0]):
        _row_of_words(key, top + r, left, width, words)
        line = out[r]
        for c in range(words.size):
            line[c] = min((F(np.uint32(words[c])) + _HALF) * _TINY, _BELOW_ONE)


@_compiled
def fill_normal(key, top, left, width, out):
    """Standard normal deviates, float32."""
    words = np.empty(out.shape[1], np.int32)
    for r in range(out.shape[0]):
        _row_of_words(key, top + r, left, width, words)
        line = out[r]
        for c in range(words.size):
            line[c] = _normal(words[c])


@_compiled
def add_normal(key, top, left, width, scale, signal):
    """signal += scale z, one scale for all, in place."""
    words = np.empty(signal.shape[1], np.int32)
    for r in range(signal.shape[0]):
        _row_of_words(key, top + r, left, width, words)
        line = signal[r]
        for c in range(words.size):
            line[c] += scale * _normal(words[c])


@_compiled
def add_scaled_normal(key, top, left, width, offset, scale, factor, signal):
    """signal += offset + factor scale z, offset and scale one a pixel, in place."""
    words = np.empty(signal.shape[1], np.int32)
    for r in range(signal.shape[0]):
        _row_of_words(key, top + r, left, width, words)
        line, base, spread = signal[r], offset[r], scale[r]
        for c in range(words.size):
            line[c] += base[c] + factor * spread[c] * _normal(words[c])


INVERTED_BELOW = F(10)  # electrons; below, Poisson counts come by exact inversion
_BLOCK = 256


@_compiled
def replace_by_counts(key, top, left, width, k, signal):
    """signal = k Pois(max(signal, 0)/k) + min(signal, 0), in place."""
    columns = signal.shape[1]
    words = np.empty(columns, np.int32)
    mean = np.empty(_BLOCK, np.float32)
    count = np.empty(_BLOCK, np.float32)
    at = np.empty(_BLOCK, np.int32)
    word, lam = np.empty(_BLOCK, np.int32), np.empty(_BLOCK, np.float32)
    work = np.empty((4, _BLOCK))
    for r in range(signal.shape[0]):
        _row_of_words(key, top + r, left, width, words)
        for start in range(0, columns, _BLOCK):
            line, here = signal[r, start : start + _BLOCK], words[start : start + _BLOCK]
            n = line.size
            few = 0
            for c in range(n):
                mean[c] = line[c] / k if line[c] > 0 else F(0)
                few += mean[c] < INVERTED_BELOW
            if few == 0:
                _many(here, mean[:n], count)
            elif few == n:
                _few(here, mean[:n], count, work)
            else:
                _sorted(here, mean[:n], few, at, word, lam)
                _few(word[:few], lam[:few], count, work)
                _many(word[few:n], lam[few:n], count[few:])
                for j in range(n):
                    mean[at[j]] = count[j]  # back to its place
                count, mean = mean, count
            for c in range(n):
                line[c] = k * count[c] + (line[c] if line[c] < 0 else F(0))


@_inlined
def _sorted(words, mean, few, at, word, lam):
    """Those of few electrons first: pixels, words and means of the block, in their order."""
    low, high = 0, few
    for c in range(mean.size):
        is_few = mean[c] < INVERTED_BELOW
        to = low if is_few else high
        at[to], word[to], lam[to] = c, words[c], mean[c]
        low += is_few
        high += not is_few


@_inlined
def _many(words, mean, count):
    """Poisson counts of means from `INVERTED_BELOW` on.

    The continuous variable that rounds to the count has its cumulants less Sheppard's corrections;
    a Cornish-Fisher expansion to fourth order gives its quantiles.
    """
    for c in range(words.size):
        z = _normal(words[c])
        lam = mean[c]
        s2 = lam - F(1 / 12)
        s = np.sqrt(s2)
        g1 = lam / (s2 * s)
        g2 = (lam + F(1 / 120)) / (s2 * s2)
        z2 = z * z
        w = z + g1 * (z2 - _ONE) * F(1 / 6)
        w += z * (g2 * (z2 - F(3)) * F(1 / 24) - g1 * g1 * (_TWO * z2 - F(5)) * F(1 / 36))
        w += g1 / s2 * (z2 * (z2 - F(6)) + F(3)) * F(1 / 120)
        w -= g1 * g2 * (z2 * (z2 - F(5)) + _TWO) * F(1 / 24)
        w += g1 * g1 * g1 * (z2 * (F(12) * z2 - F(53)) + F(17)) * F(1 / 324)
        n = np.rint(lam + s * w)
        count[c] = n if n > 0 else F(0)


@_inlined
def _few(words, mean, count, work):
    """Poisson counts of means below `INVERTED_BELOW`: least k with P(X > k) <= 1 - u."""
    lam, p, above, tail = work[0], work[1], work[2], work[3]
    n = words.size
    for j in range(n):
        lam[j] = mean[j]
        x = lam[j] * (-1.0 / 16)
        e = 1.0 + x * (
            1 / 12
        )  # Taylor series of exp, relative error below 1e-13 after the squarings
        e = 1.0 + x * (1 / 11) * e
        e = 1.0 + x * (1 / 10) * e
        e = 1.0 + x * (1 / 9) * e
        e = 1.0 + x * (1 / 8) * e
        e = 1.0 + x * (1 / 7) * e
        e = 1.0 + x * (1 / 6) * e
        e = 1.0 + x * (1 / 5) * e
        e = 1.0 + x * (1 / 4) * e
        e = 1.0 + x * (1 / 3) * e
        e = 1.0 + x * (1 / 2) * e
        e = 1.0 + x * e
        e *= e
        e *= e
        e *= e
        e *= e
        p[j] = e
        above[j] = 1.0 - e
        tail[j] = (np.float64(~np.uint32(words[j])) + 0.5) * 2.0**-32
        count[j] = 0
    for k in range(1, 64):
        more = 0
        inverse = 1.0 / k
        for j in range(n):
            bigger = tail[j] < above[j]
            more += bigger
            count[j] += F(1) if bigger else F(0)
            p[j] *= lam[j] * inverse
            above[j] -= p[j]
        if more == 0:
            break


@_compiled
def share_with_neighbours(signal, edge, corner, uneven, out):
    """out = 3x3 convolution of signal, of sum 1; the frame's edge is repeated.

    Weights: ``edge + uneven`` along the row, ``edge - uneven`` along the column, ``corner``.
    """
    rows, columns = signal.shape
    centre = F(1) - F(4) * edge - F(4) * corner
    sides = np.empty(columns, np.float32)
    for r in range(rows):
        up, here, down = signal[max(r - 1, 0)], signal[r], signal[min(r + 1, rows - 1)]
        line = out[r]
        for c in range(columns):
            sides[c] = up[c] + down[c]
        for c in range(1, columns - 1):
            along = here[c - 1] + here[c + 1]
            line[c] = (
                centre * here[c]
                + edge * (sides[c] + along)
                + corner * (sides[c - 1] + sides[c + 1])
                + uneven * (along - sides[c])
            )
        for c in (0, columns - 1):
            a, b = max(c - 1, 0), min(c + 1, columns - 1)
            along = here[a] + here[b]
            line[c] = (
                centre * here[c]
                + edge * (sides[c] + along)
                + corner * (sides[a] + sides[b])
                + uneven * (along - sides[c])
            )


_LOG2E, _LN2_HIGH, _LN2_LOW = F(1.4426950408889634), F(0.693359375), F(-2.12194440e-4)
_BIAS = np.int32(127)


@_inlined
def exp(x):
    """Exponential of a float32, relative error below 2e-7, held inside the normal range."""
    x = x if x > F(-87) else F(-87)
    x = x if x < F(88) else F(88)
    n = np.rint(x * _LOG2E)
    r = (x - n * _LN2_HIGH) - n * _LN2_LOW
    p = F(1 / 5040) * r + F(1 / 720)
    p = p * r + F(1 / 120)
    p = p * r + F(1 / 24)
    p = p * r + F(1 / 6)
    p = p * r + _HALF
    p = p * r + _ONE
    p = p * r + _ONE
    return p * _as_float((np.int32(n) + _BIAS) << _SHIFT)


@_inlined
def _seed_row(key, row, left, width, mu, delta, words, light):
    """One row of exp(mu + delta z)."""
    _row_of_words(key, row, left, width, words)
    for c in range(words.size):
        light[c] = exp(mu + delta * _normal(words[c]))


@_inlined
def _kernel_row(up, here, down, phi, column, square, mean, norm):
    """Mean and norm of the random 3x3 kernel on one row; the end columns are repeated."""
    n = here.size
    for c in range(n):
        column[c + 1] = up[c] + here[c] + down[c]
        square[c + 1] = up[c] * up[c] + here[c] * here[c] + down[c] * down[c]
    column[0], column[n + 1] = column[1], column[n]
    square[0], square[n + 1] = square[1], square[n]
    centre = _ONE - F(9) * phi
    for c in range(n):
        mean[c] = phi * (column[c] + column[c + 1] + column[c + 2]) + centre * here[c]
        norm[c] = np.sqrt(square[c] + square[c + 1] + square[c + 2])


@_compiled
def replace_by_rank(levels, near, signal):
    """signal = how many of the ascending ``levels`` it reaches, in place; (pixels,).

    Level k lies not far from ``near`` + k, where the search begins.
    """
    for i in range(signal.size):
        x = signal[i]
        k = min(max(np.int64(x) - near, 0), levels.size)
        while k < levels.size and levels[k] <= x:
            k += 1
        while k > 0 and levels[k - 1] > x:
            k -= 1
        signal[i] = k


@_compiled
def fill_lognormal(key, top, left, width, mu, delta, phi, mean, norm):
    """Mean and norm of the paper's random kernel on a log-normal seed; the edges are repeated."""
    rows, columns = mean.shape
    words = np.empty(columns, np.int32)
    light = np.empty((3, columns), np.float32)
    column, square = np.empty(columns + 2, np.float32), np.empty(columns + 2, np.float32)
    _seed_row(key, top, left, width, mu, delta, words, light[0])
    for r in range(rows):
        if r + 1 < rows:
            _seed_row(key, top + r + 1, left, width, mu, delta, words, light[(r + 1) % 3])
        up, down = light[(max(r, 1) - 1) % 3], light[min(r + 1, rows - 1) % 3]
        _kernel_row(up, light[r % 3], down, phi, column, square, mean[r], norm[r])


@_compiled
def add_lognormal(seed, taps, top, left, width, mu, delta, phi, sigma, signal):
    """The paper's model in one pass: `fill_lognormal` of key ``seed``, noise of key ``taps``."""
    rows, columns = signal.shape
    words = np.empty(columns, np.int32)
    light = np.empty((3, columns), np.float32)
    column, square = np.empty(columns + 2, np.float32), np.empty(columns + 2, np.float32)
    mean, norm = np.empty(columns, np.float32), np.empty(columns, np.float32)
    _seed_row(seed, top, left, width, mu, delta, words, light[0])
    for r in range(rows):
        if r + 1 < rows:
            _seed_row(seed, top + r + 1, left, width, mu, delta, words, light[(r + 1) % 3])
        up, down = light[(max(r, 1) - 1) % 3], light[min(r + 1, rows - 1) % 3]
        _kernel_row(up, light[r % 3], down, phi, column, square, mean, norm)
        _row_of_words(taps, top + r, left, width, words)
        line = signal[r]
        for c in range(columns):
            line[c] += mean[c] + sigma * norm[c] * _normal(words[c])
