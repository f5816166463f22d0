"""Single lines that stand out of a pattern, and how far along it each of them does."""

from __future__ import annotations

import numpy as np

from dnanalyze.robust import robust_deviation

SURE = 5.0  # robust deviations: one Gaussian line in 1.7 million is farther off
SINGLE_LINES = 0.1  # share of the lines up to which they are single ones
LOUDEST = 64  # lines that are looked at
FEWEST, NEAR = 32, 15  # lines: of a profile, and of the neighbourhood that sets the level
COUNTED_DEVIATIONS = 4.0  # robust deviations to which a pixel counts
KNOTS = 64  # places along a line that are tried first
PARTIAL = 40.0  # gain in log likelihood, doubled, from which a line is taken to be a part of one


def against_neighbours(profile: np.ndarray) -> np.ndarray:
    """Each line less the median of the 15 around it."""
    import scipy.ndimage

    return np.asarray(profile - scipy.ndimage.median_filter(profile, NEAR, mode="reflect"))


def standing_out(profile: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the lines far off their neighbours, and their offsets; none where many are.

    Parameters
    ----------
    profile : ndarray
        (lines,), mean of each.
    """
    if profile.size < FEWEST:
        return np.empty(0, int), np.empty(0)
    apart = against_neighbours(profile)
    spread = robust_deviation(apart)
    far = np.flatnonzero(np.abs(apart) > SURE * spread)
    if far.size > SINGLE_LINES * profile.size:
        far = far[:0]
    return far, apart[far]


def defects(pattern: np.ndarray, profile: np.ndarray) -> np.ndarray:
    """Columns that stand out, each with its offset, its first row and the row after its last.

    Parameters
    ----------
    pattern : ndarray
        (rows, columns), DN; give the transposed pattern for rows.
    profile : ndarray
        (columns,), their means.

    Returns
    -------
    ndarray
        (defects, 4): column, offset in DN, first row, row after the last.
    """
    columns, offsets = standing_out(profile)
    loudest = np.sort(np.argsort(-np.abs(offsets), kind="stable")[:LOUDEST])
    extents = [_extent(pattern, int(columns[k]), offsets[k] > 0) for k in loudest]
    return np.array(extents).reshape(-1, 4)


def _extent(pattern: np.ndarray, column: int, above: bool) -> tuple[float, float, float, float]:
    """A column against the median of those around it."""
    left = max(0, column - NEAR // 2)
    around = np.delete(pattern[:, left : column + NEAR // 2 + 1], column - left, axis=1)
    level = np.median(around, axis=1)
    off = np.asarray(pattern[:, column] - level, float)
    spread = robust_deviation(around - level[:, None], 0.0)
    spread = spread or float(np.abs(off).max())  # of constant lines around
    first, last = _part(
        np.clip((off if above else -off) / spread, -COUNTED_DEVIATIONS, COUNTED_DEVIATIONS)
    )
    return float(column), float(np.median(off[first:last])), float(first), float(last)


def _part(sigmas: np.ndarray) -> tuple[int, int]:
    """Where along a line its pixels are above 0: the likeliest part, or the whole of it."""
    n = sigmas.size
    total = np.concatenate([[0.0], np.cumsum(sigmas)])
    ends = np.unique(np.linspace(0, n, min(n, KNOTS) + 1).astype(int))
    first, last = _likeliest(total, ends, ends)
    step = int(np.diff(ends).max())
    near = [np.arange(max(0, e - step), min(n, e + step) + 1) for e in (first, last)]
    first, last = _likeliest(total, *near)
    gain = _likelihood(total, np.array([first, 0]), np.array([last, n]))
    return (first, last) if gain[0] - gain[1] > PARTIAL else (0, n)


def _likeliest(total: np.ndarray, first: np.ndarray, last: np.ndarray) -> tuple[int, int]:
    score = _likelihood(total, first[:, None], last[None, :])
    i, j = np.unravel_index(int(np.argmax(score)), score.shape)
    return int(first[i]), int(last[j])


def _likelihood(total: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Twice the log likelihood ratio of an offset from ``first`` to ``last`` to none."""
    above = np.maximum(total[last] - total[first], 0.0)
    return np.where(last > first, above**2 / np.maximum(last - first, 1), 0.0)
