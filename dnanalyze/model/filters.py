"""Filters within a frame: defect-pixel correction and denoise, over all pixels or within a colour.

Every filter mirrors the frame at its edges, without repeating the edge pixel, and gives float32.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit

from dnanalyze.model.kernels import exp

Corner = tuple[int, int]  # row and column


def planewise(
    function: Callable[[np.ndarray, Corner], np.ndarray],
    image: np.ndarray,
    spacing: int,
    corner: Corner = (0, 0),
) -> np.ndarray:
    """Apply a filter to each of the spacing x spacing interleaved planes of a mosaic by itself.

    ``corner``: row and column of the frame at which the image begins; the filter is told those of
    its plane.
    """
    if spacing == 1:
        return function(image, corner)
    result = np.empty_like(image)
    for dy in range(spacing):
        for dx in range(spacing):
            plane = np.ascontiguousarray(image[dy::spacing, dx::spacing])
            begins = (corner[0] + dy) // spacing, (corner[1] + dx) // spacing
            result[dy::spacing, dx::spacing] = function(plane, begins)
    return result


def rounded_like(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """``after`` in float32, rounded to whole numbers where ``before`` is all whole numbers."""
    if np.array_equal(before, np.rint(before)):
        return np.rint(after).astype(np.float32, copy=False)
    return after.astype(np.float32, copy=False)


@njit(cache=True, nogil=True, inline="always")
def _mirror(i: int, n: int) -> int:
    """Index mirrored into 0 ... n - 1."""
    if n == 1:
        return 0
    while i < 0 or i >= n:
        if i < 0:
            i = -i
        if i >= n:
            i = 2 * n - 2 - i
    return i


@njit(cache=True, nogil=True, inline="always")
def _gather(image: np.ndarray, r: int, c: int, radius: int, values: np.ndarray) -> int:
    """Neighbours of (r, c) out to ``radius`` in both axes, without the pixel itself."""
    rows, columns = image.shape
    count = 0
    for dy in range(-radius, radius + 1):
        y = _mirror(r + dy, rows)
        for dx in range(-radius, radius + 1):
            if dy == 0 and dx == 0:
                continue
            values[count] = image[y, _mirror(c + dx, columns)]
            count += 1
    return count


@njit(cache=True, nogil=True, inline="always")
def _sort(values: np.ndarray, count: int) -> None:
    """Insertion sort: the fastest for so few."""
    for i in range(1, count):
        v = values[i]
        j = i - 1
        while j >= 0 and values[j] > v:
            values[j + 1] = values[j]
            j -= 1
        values[j + 1] = v


# MEDIAN is the upper of the two middle values, a rank, as hardware and rank filters take it;
# MIDPOINT is the mean of the two; EXTREME caps.
MEDIAN, MEAN, EXTREME, MIDPOINT = 0, 1, 2, 3


@njit(cache=True, nogil=True, inline="always")
def _centre(values: np.ndarray, n: int, replacement: int) -> float:
    """What stands for ``n`` neighbours; sorts them unless it is their mean."""
    if replacement == MEAN:
        return values[:n].mean()
    _sort(values, n)
    if replacement == MIDPOINT:
        return np.float32(0.5) * (values[n // 2 - 1] + values[n // 2])
    return values[n // 2]


@njit(cache=True, nogil=True)
def replace_outliers(
    image: np.ndarray, threshold: float, local: bool, both: bool, replacement: int
) -> np.ndarray:
    """Replace a pixel that lies beyond a threshold off the median or mean of its 8 neighbours.

    Parameters
    ----------
    image : ndarray, shape (rows, columns), float32
    threshold : float
        DN, or with ``local`` in units of the neighbours' own spread (their range over 2.85, which
        is the standard deviation of eight Gaussian deviates).
    local : bool
        See ``threshold``.
    both : bool
        Also pixels below.
    replacement : int
        ``MEDIAN``, ``MIDPOINT`` or ``MEAN`` of the neighbours: what a pixel is held against and
        replaced by.
    """
    rows, columns = image.shape
    result = image.copy()
    for r in range(rows):
        values = np.empty(8, np.float32)
        for c in range(columns):
            _gather(image, r, c, 1, values)
            reference = _centre(values, 8, replacement)
            limit = threshold
            if local:
                limit *= (values.max() - values.min()) / 2.847
            off = image[r, c] - reference
            if off > limit or (both and -off > limit):
                result[r, c] = reference
    return result


@njit(cache=True, nogil=True)
def replace_excess(
    image: np.ndarray, threshold: float, both: bool, radius: int, replacement: int
) -> np.ndarray:
    """Replace a pixel that exceeds the largest neighbour by a threshold (DN).

    ``replacement``: ``MEDIAN``, ``MEAN`` or ``EXTREME`` of the neighbours: the largest, which caps
    it. With ``both`` a pixel below the smallest likewise. ``radius`` 1: 8 neighbours; 2: 24.
    """
    rows, columns = image.shape
    result = image.copy()
    for r in range(rows):
        values = np.empty(24, np.float32)
        for c in range(columns):
            n = _gather(image, r, c, radius, values)
            high, low = values[0], values[0]
            for k in range(1, n):
                high, low = max(high, values[k]), min(low, values[k])
            above = image[r, c] > high + threshold
            if above or (both and image[r, c] < low - threshold):
                if replacement == EXTREME:
                    result[r, c] = high if above else low
                else:
                    result[r, c] = _centre(values, n, replacement)
    return result


@njit(cache=True, nogil=True)
def replace_by_ratio(
    image: np.ndarray, factor: float, threshold: float, black: float, radius: int, replacement: int
) -> np.ndarray:
    """Replace where y - black > factor (largest neighbour - black) + threshold.

    ``replacement``: ``MEDIAN``, ``MEAN`` or ``EXTREME`` (the largest) of the neighbours;
    ``radius`` as for `replace_excess`. Where the largest neighbour is below black it counts as
    black.
    """
    rows, columns = image.shape
    result = image.copy()
    for r in range(rows):
        values = np.empty(24, np.float32)
        for c in range(columns):
            n = _gather(image, r, c, radius, values)
            high = values[0]
            for k in range(1, n):
                high = max(high, values[k])
            if image[r, c] - black > factor * max(high - black, 0.0) + threshold:
                if replacement == EXTREME:
                    result[r, c] = high
                else:
                    result[r, c] = _centre(values, n, replacement)
    return result


@njit(cache=True, nogil=True)
def neighbour_centre(image: np.ndarray, replacement: int) -> np.ndarray:
    """``MEDIAN`` or ``MEAN`` of the 8 neighbours of every pixel."""
    rows, columns = image.shape
    result = np.empty_like(image)
    for r in range(rows):
        values = np.empty(8, np.float32)
        for c in range(columns):
            _gather(image, r, c, 1, values)
            result[r, c] = _centre(values, 8, replacement)
    return result


@njit(cache=True, nogil=True)
def with_margin(image: np.ndarray, margin: int) -> np.ndarray:
    """The frame with as many pixels mirrored around it."""
    rows, columns = image.shape
    padded = np.empty((rows + 2 * margin, columns + 2 * margin), np.float32)
    for r in range(rows + 2 * margin):
        a = _mirror(r - margin, rows)
        for c in range(margin):
            padded[r, c] = image[a, _mirror(c - margin, columns)]
            padded[r, margin + columns + c] = image[a, _mirror(columns + c, columns)]
        for c in range(columns):
            padded[r, margin + c] = image[a, c]
    return padded


# Loops without branches, to fill whole vectors
@njit(cache=True, nogil=True, inline="always")
def smaller(a: float, b: float) -> float:
    """The smaller of two."""
    return a if a < b else b


@njit(cache=True, nogil=True, inline="always")
def larger(a: float, b: float) -> float:
    """The larger of two."""
    return a if a > b else b


@njit(cache=True, nogil=True, inline="always")
def _middle(a: float, b: float, c: float) -> float:
    return larger(smaller(a, b), smaller(larger(a, b), c))


@njit(cache=True, nogil=True)
def median3(image: np.ndarray) -> np.ndarray:
    """Median of the 3x3 window, the pixel included.

    With every column of the window sorted it is the middle one of the largest of the smallest, the
    middle one of the middle ones, and the smallest of the largest.
    """
    rows, columns = image.shape
    y = with_margin(image, 1)
    result = np.empty_like(image)
    low, mid = np.empty(columns + 2, np.float32), np.empty(columns + 2, np.float32)
    high = np.empty(columns + 2, np.float32)
    for r in range(rows):
        up, here, down = y[r], y[r + 1], y[r + 2]
        for c in range(columns + 2):
            low[c] = smaller(smaller(up[c], here[c]), down[c])
            mid[c] = _middle(up[c], here[c], down[c])
            high[c] = larger(larger(up[c], here[c]), down[c])
        for c in range(columns):
            result[r, c] = _middle(
                larger(larger(low[c], low[c + 1]), low[c + 2]),
                _middle(mid[c], mid[c + 1], mid[c + 2]),
                smaller(smaller(high[c], high[c + 1]), high[c + 2]),
            )
    return result


@njit(cache=True, nogil=True)
def bilateral(image: np.ndarray, range_dn: float, space: float, radius: int) -> np.ndarray:
    """Mean of the window, weighted by distance and by likeness.

    w = exp(-d^2 / 2 space^2 - (y_k - y)^2 / 2 range^2)  (Tomasi and Manduchi, ICCV 1998).

    Parameters
    ----------
    image : ndarray, shape (rows, columns), float32
    range_dn : float
        DN.
    space : float
        Pixels.
    radius : int
        Half width of the window, pixels.
    """
    rows, columns = image.shape
    y = with_margin(image, radius)
    result = np.empty_like(image)
    like = np.float32(-0.5 / (range_dn * range_dn))
    total, weight = np.empty(columns, np.float32), np.empty(columns, np.float32)
    for r in range(rows):
        here = y[r + radius, radius : radius + columns]
        total[:], weight[:] = np.float32(0.0), np.float32(0.0)
        for dy in range(-radius, radius + 1):
            for dx in range(-radius, radius + 1):
                there = y[r + radius + dy, radius + dx : radius + dx + columns]
                near = np.float32(-(dy * dy + dx * dx) / (2 * space * space))
                for c in range(columns):
                    off = there[c] - here[c]
                    w = exp(near + like * off * off)
                    total[c] += w * off
                    weight[c] += w
        for c in range(columns):
            result[r, c] = here[c] + total[c] / weight[c]
    return result


def gaussian_kernel(sigma: float, radius: int) -> np.ndarray:
    """Weights along a line, (2 radius + 1,); their sum is 1."""
    weights = np.exp(-0.5 * (np.arange(-radius, radius + 1) / sigma) ** 2)
    return np.asarray(weights / weights.sum())


def gaussian(image: np.ndarray, sigma: float, radius: int) -> np.ndarray:
    """Gaussian smoothing, sigma in pixels, cut off at ``radius``."""
    from scipy.ndimage import correlate1d

    kernel = gaussian_kernel(sigma, radius)
    once = correlate1d(image, kernel, axis=0, mode="mirror", output=np.float32)
    return correlate1d(once, kernel, axis=1, mode="mirror", output=np.float32)


@njit(cache=True, nogil=True)
def _add(w: np.ndarray, values: np.ndarray, total: np.ndarray, weight: np.ndarray, n: int) -> None:
    """The first ``n`` values with their weights."""
    for c in range(n):
        total[c] += w[c] * values[c]
    for c in range(n):
        weight[c] += w[c]


@njit(cache=True, nogil=True)
def nonlocal_means(image: np.ndarray, h: float, patch: int, distance: int) -> np.ndarray:
    """Mean of the pixels around, weighted by how alike their patches are.

    w = exp(-D / h^2), D the mean squared difference of two patches, over (2 distance + 1)^2 places
    (Buades, Coll, Morel, CVPR 2005; flat patches).

    Parameters
    ----------
    image : ndarray, shape (rows, columns), float32
    h : float
        DN.
    patch : int
        Pixels a side; of an even one a row and a column more lie after the pixel than before it, as
        scikit-image's fast mode makes of the next odd one.
    distance : int
        Half width of the search window, pixels.
    """
    rows, columns = image.shape
    before, after = (patch - 1) // 2, patch // 2
    margin = after + distance
    padded = with_margin(image, margin)
    scale = np.float32(-1.0 / (patch * patch * h * h))
    total = padded.copy()  # each place is like itself
    weight = np.ones_like(padded)
    below, w = np.empty(columns + 2 * margin, np.float32), np.empty_like(padded[0])
    # Two places are as alike as the other way round: each pair is met once, at its upper place.
    for r in range(after, rows + margin):
        for dy in range(distance + 1):
            for dx in range(-distance if dy else 1, distance + 1):
                first, many = max(0, -dx), columns + 2 * margin - abs(dx)
                below[:many] = np.float32(0.0)
                for k in range(-before, after + 1):
                    here = padded[r + k, first : first + many]
                    there = padded[r + k + dy, first + dx : first + dx + many]
                    for c in range(many):
                        d = here[c] - there[c]
                        below[c] += d * d
                many, first = many - (patch - 1), first + before
                w[:many] = np.float32(0.0)
                for k in range(patch):
                    part = below[k : k + many]
                    for c in range(many):
                        w[c] += part[c]
                for c in range(many):
                    s = scale * w[c]
                    # weights below e^-5 count as none, as in scikit-image
                    w[c] = exp(s) if s >= np.float32(-5.0) else np.float32(0.0)
                _add(w, padded[r + dy, first + dx :], total[r, first:], weight[r, first:], many)
                _add(
                    w,
                    padded[r, first:],
                    total[r + dy, first + dx :],
                    weight[r + dy, first + dx :],
                    many,
                )
    inside = total[margin : margin + rows, margin : margin + columns]
    return inside / weight[margin : margin + rows, margin : margin + columns]
