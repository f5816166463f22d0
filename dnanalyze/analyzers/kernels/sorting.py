"""Order of single-precision numbers by their bits: about five times as fast as by comparisons.

The bits of a float32 are in the order of the numbers once the sign bit is set for positive numbers,
and all bits are inverted for negative ones. No number may be NaN; -0 becomes 0.
"""

from __future__ import annotations

import numpy as np
from numba import njit

SIGN = np.uint32(0x80000000)
DIGITS, DIGIT_BITS = 3, 11
HALF_BITS = np.uint32(16)


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
    """The value at a place of the ascending order, and how many are below and equal to it."""
    keys = np.empty(values.size, np.uint32)
    _into_keys(values, keys)
    counts = np.zeros(1 << HALF_BITS, np.int64)
    for key in keys:
        counts[key >> HALF_BITS] += 1
    below, high = 0, np.uint32(0)
    while below + counts[high] <= place:
        below += counts[high]
        high += np.uint32(1)
    counts[:] = 0
    for key in keys:
        if key >> HALF_BITS == high:
            counts[key & np.uint32(0xFFFF)] += 1
    low = np.uint32(0)
    while below + counts[low] <= place:
        below += counts[low]
        low += np.uint32(1)
    found = np.empty(1, np.uint32)
    found[0] = (high << HALF_BITS) | low
    return _from_keys(found)[0], below, counts[low]
