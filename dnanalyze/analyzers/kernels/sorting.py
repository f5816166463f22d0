"""Order of single-precision numbers by their bits: about five times as fast as by comparisons.

The bits of a float32 are in the order of the numbers once the sign bit is set for positive numbers,
and all bits are inverted for negative ones. No number may be NaN; -0 becomes 0.
"""

from __future__ import annotations

import numpy as np
from numba import njit

SIGN = np.uint32(0x80000000)
DIGITS, DIGIT_BITS = 3, 11


@njit(nogil=True, inline="always")
def _into_keys(values, keys):
    positive = np.empty(values.size, np.float32)
    for i in range(values.size):
        positive[i] = values[i] + np.float32(0.0)  # -0 becomes 0
    bits = positive.view(np.uint32)
    for i in range(values.size):
        keys[i] = ~bits[i] if bits[i] & SIGN else bits[i] | SIGN


@njit(nogil=True, inline="always")
def _from_keys(keys):
    values = np.empty(keys.size, np.float32)
    bits = values.view(np.uint32)
    for i in range(keys.size):
        bits[i] = keys[i] & ~SIGN if keys[i] & SIGN else ~keys[i]
    return values


@njit(nogil=True, inline="always")
def _digit(key, number):
    return (key >> np.uint32(DIGIT_BITS * number)) & np.uint32((1 << DIGIT_BITS) - 1)


@njit(cache=True, nogil=True)
def radix_sorted(values):
    """The values in ascending order, float32."""
    n = values.size
    keys, other = np.empty(n, np.uint32), np.empty(n, np.uint32)
    _into_keys(values, keys)
    places = np.zeros((DIGITS, 1 << DIGIT_BITS), np.int64)
    for i in range(n):
        for number in range(DIGITS):
            places[number, _digit(keys[i], number)] += 1
    for number in range(DIGITS):
        place = places[number]
        before = 0
        for value in range(place.size):
            count = place[value]
            place[value] = before
            before += count
        for i in range(n):
            value = _digit(keys[i], number)
            other[place[value]] = keys[i]
            place[value] += 1
        keys, other = other, keys
    return _from_keys(keys)


@njit(cache=True, nogil=True)
def order_statistic(values, place):
    """The value at a place of the ascending order, and how many are below and equal to it.

    Bins over the range of what is left tell the one that holds the place, until all in it are
    alike.
    """
    keys = np.empty(values.size, np.uint32)
    _into_keys(values, keys)
    counts = np.empty(1 << DIGIT_BITS, np.int64)
    below = 0
    lowest, highest = _ends(keys)
    while lowest < highest:
        shift = np.uint32(0)
        while (highest - lowest) >> shift >> np.uint32(DIGIT_BITS):
            shift += np.uint32(1)
        counts[:] = 0
        for key in keys:
            counts[(key - lowest) >> shift] += 1
        held = np.uint32(0)
        while below + counts[held] <= place:
            below += counts[held]
            held += np.uint32(1)
        kept = 0
        for i in range(keys.size):
            key = keys[i]
            keys[kept] = key
            kept += np.uint32((key - lowest) >> shift) == held
        keys = keys[:kept]
        lowest, highest = _ends(keys)
    return _from_keys(keys[:1])[0], below, keys.size


@njit(nogil=True, inline="always")
def _ends(keys):
    lowest, highest = keys[0], keys[0]
    for key in keys:
        lowest, highest = min(lowest, key), max(highest, key)
    return lowest, highest
