"""Means of blocks, rows and columns over a whole field, however large."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from dnanalyze.loaders.captures import Window
from dnanalyze.robust import robust_deviation

BLOCK = 32  # pixels a side: the mean of a block repeats to 1/32 of the noise of a pixel
# Standard deviations from the median; of normal noise 1 pixel in 2 million is farther.
CLIPPED = 5.0
SAMPLE = 100_000  # pixels that tell the standard deviation
BAND = 16 * BLOCK  # rows taken at a time
_BODY = slice(SAMPLE // 100, -SAMPLE // 100)  # 98 % of the sample
ACROSS = 33  # lines of a running median, which has 1.25 / sqrt(33) = 22 % of the noise of a line


@dataclass(frozen=True)
class FieldProfile:
    """What a mean frame looks like from afar.

    Pixels far from the median of their frame count as `CLIPPED` standard deviations off, so that a
    hot pixel moves no mean.

    Parameters
    ----------
    blocks : ndarray
        Means of blocks of `BLOCK` x `BLOCK` pixels, DN; rows and columns over are left out.
    rows, columns : ndarray
        Means of each row and column, DN.
    noise : float
        Standard deviation of the pixels of one frame, DN (robust).
    """

    blocks: np.ndarray
    rows: np.ndarray
    columns: np.ndarray
    noise: float

    def less(self, other: FieldProfile) -> FieldProfile:
        """The difference of two profiles of one field size."""
        return FieldProfile(
            self.blocks - other.blocks,
            self.rows - other.rows,
            self.columns - other.columns,
            self.noise,
        )

    def blocks_in(self, window: Window) -> np.ndarray:
        """Means of the blocks that lie in a window whole."""
        rows = slice(-(-window.top // BLOCK), window.bottom // BLOCK)
        columns = slice(-(-window.left // BLOCK), window.right // BLOCK)
        return self.blocks[rows, columns]

    def lines(self, axis: str, period: int = 1) -> np.ndarray:
        """Means of the "rows" or "columns" less their smooth course, DN.

        ``period``: of the colour filter along them; each of its lines has a course of its own.
        """
        means = np.asarray(getattr(self, axis), float)
        found = np.empty_like(means)
        for first in range(period):
            own = _untilted(means[first::period])
            found[first::period] = own - median_filter(own, ACROSS, mode="reflect")
        return found


def _untilted(means: np.ndarray) -> np.ndarray:
    """Without their parabola, by which the ends would differ from their mirror images."""
    count = means.size // ACROSS
    if count < 4:  # a parabola of three medians would be exact
        return means
    place = np.arange(means.size, dtype=float)
    cut = slice(0, count * ACROSS)
    at, middle = (np.median(x[cut].reshape(count, ACROSS), axis=1) for x in (place, means))
    return np.asarray(means - np.polyval(np.polyfit(at, middle, 2), place))


def field_profile(frames: Iterable[np.ndarray]) -> FieldProfile:
    """The profile of the mean of some frames of one operating point.

    Parameters
    ----------
    frames : iterable of ndarray
        Whole frames, (rows, columns), DN; each is asked for once.

    Raises
    ------
    ValueError
        There is no frame.

    Examples
    --------
    >>> import numpy as np
    >>> from dnanalyze.analyzers.field_profile import field_profile
    >>> frame = np.zeros((64, 96)); frame[:, 70] = 3.0; frame[::2] += 1.0
    >>> found = field_profile([frame])
    >>> found.blocks.shape, int(np.argmax(found.lines("columns")))
    ((2, 3), 70)
    """
    total: FieldProfile | None = None
    count = 0
    for frame in frames:
        seen = _of_one(frame)
        count += 1
        total = seen if total is None else _sum(total, seen)
    if total is None:
        raise ValueError("field_profile: no frames")
    return FieldProfile(
        total.blocks / count, total.rows / count, total.columns / count, total.noise / count
    )


def _of_one(frame: np.ndarray) -> FieldProfile:
    rows, columns = frame.shape
    some = np.random.default_rng(0).integers(0, frame.size, SAMPLE)
    sample = frame.ravel()[some].astype(float)
    middle = float(np.median(sample))
    # of coarse codes most are the median
    noise = robust_deviation(sample, middle) or float(np.std(np.sort(sample)[_BODY]))
    low, high = middle - CLIPPED * noise, middle + CLIPPED * noise
    whole = columns // BLOCK * BLOCK
    blocks, row_means, sums = [], [], np.zeros(columns)
    for top in range(0, rows, BAND):
        band = np.asarray(frame[top : top + BAND], np.float32)
        if noise > 0.0:
            band = np.clip(band, low, high)
        row_means.append(band.mean(axis=1, dtype=float))
        sums += band.sum(axis=0, dtype=float)
        full = len(band) // BLOCK
        cut = band[: full * BLOCK, :whole].reshape(full, BLOCK, whole // BLOCK, BLOCK)
        blocks.append(cut.mean(axis=(1, 3), dtype=float))
    return FieldProfile(
        np.concatenate(blocks), np.concatenate(row_means), sums / rows, float(noise)
    )


def _sum(one: FieldProfile, other: FieldProfile) -> FieldProfile:
    return FieldProfile(
        one.blocks + other.blocks,
        one.rows + other.rows,
        one.columns + other.columns,
        one.noise + other.noise,
    )
