"""How far pixels stand out of their neighbours: a dynamic correction leaves a cliff.

A dynamic corrector, a clamp and a ratio rule all forbid a pixel to stand out of its *own*
neighbours by more than some bound, and know nothing of neighbours elsewhere. So the excess
x - max(neighbours) is held against the excess of the same pixels over rings of neighbours a few
pixels away (the control). Where pixels are exchangeable at that scale the control is no more
frequent, whatever the marginal; above the threshold of a corrector only the control has any. The
control takes the larger of two rings on opposite sides, so that a gradient cannot feed it.

A rule x > a max + b has its sharp edge in x - a max. With a slope that is too small what survives
beside hot neighbours blurs the edge; with one that is too large it stays sharp, since max is never
far below the median. So a few slopes find every such rule, and the least sharp one is its own.
"""

from __future__ import annotations

import operator
from dataclasses import dataclass
from functools import reduce

import numpy as np

from dnanalyze.detection.ring import ring_maximum
from dnanalyze.significance import CERTAIN

AWAY = 8  # pixels to the rings of the control: along the row and the column, of the same colour
LADDER = np.concatenate([np.arange(0, 8, 0.25), np.geomspace(8, 4000, 64)])  # in units of the noise
RATIOS = np.geomspace(1.0, 20.0, LADDER.size)  # crosstalk of 2 % forbids more than 42 by itself
SLOPES = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
MOST_PAIRS = 1 << 13  # kept of a stack


@dataclass(frozen=True)
class Excess:
    """Counts of pixels that exceed their neighbours' maximum by more than each bound."""

    bounds: np.ndarray  # DN, or ratios
    # Count over all frames; the control's is the mean over the displaced rings.
    own: np.ndarray
    control: np.ndarray
    frames: int  # frames that went in; a hot pixel counts in each

    def __add__(self, other: Excess) -> Excess:
        frames = max(self.frames, other.frames)
        return Excess(self.bounds, self.own + other.own, self.control + other.control, frames)


@dataclass(frozen=True)
class StandingOut:
    """How far pixels stand out of the largest of their neighbours, in three ways."""

    neighbours: int  # 8 or 24
    difference: Excess  # x - max, DN, of pixels above the frame's median
    ratio: Excess  # (x - median) / (max - median), of pixels 6 units above the median
    # (x - median) - a (max - median), DN, of the same pixels, for each a of ``SLOPES``.
    sloped: tuple[Excess, ...]
    base: float  # median of the frames, DN
    # (n, 4), some of the same pixels, DN as recorded, with the largest of their own ring and the
    # larger of two rings on opposite sides, along rows, along columns.
    pairs: np.ndarray

    def along(self, slope: float) -> Excess:
        """(x - median) - slope (max - median) for one of ``SLOPES``."""
        return self.sloped[SLOPES.index(slope)]

    def __add__(self, other: StandingOut) -> StandingOut:
        sloped = tuple(a + b for a, b in zip(self.sloped, other.sloped, strict=True))
        pairs = np.concatenate([self.pairs, other.pairs])
        difference, ratio = self.difference + other.difference, self.ratio + other.ratio
        base = min(self.base, other.base)
        return StandingOut(self.neighbours, difference, ratio, sloped, base, pairs)


def standing_out(
    stack: np.ndarray,
    reach: int,
    unit: float,
    ceiling: float = np.inf,
    replaced: np.ndarray | None = None,
) -> StandingOut:
    """Own and control counts over a stack of frames as recorded.

    Parameters
    ----------
    stack : ndarray
        (frames, rows, columns), DN.
    reach : int
        1: 8 neighbours, 2: 24.
    unit : float
        Noise, DN, by which the ladder of bounds is scaled.
    ceiling : float
        Pixels at or above are saturated and left out.
    replaced : ndarray, optional
        (n, 2), rows and columns of sites that look replaced. Pixels beside them are left out: a
        corrector replaces a pixel but not its fainter hot neighbour, which then stands alone.
    """
    margin, floor, ladder = reach + AWAY, CERTAIN * unit, LADDER * unit
    free = np.ones(stack.shape[1:], bool)
    for y, x in replaced if replaced is not None else ():
        free[max(0, y - reach) : y + reach + 1, max(0, x - reach) : x + reach + 1] = False
    free = free[margin:-margin, margin:-margin]
    frames = len(stack)
    bases, leads, hot = [], [], []
    for frame in stack:
        base = float(np.median(frame[::5, ::5]))
        pixel = frame[margin:-margin, margin:-margin]
        seen = free & (pixel >= base) & (pixel < ceiling)
        with_rings = np.stack([pixel[seen], *(ring[seen] for ring in _rings(frame, reach))]) - base
        leads.append(_excess(with_rings[0] - with_rings[1:], ladder, frames))
        hot.append(with_rings[:, with_rings[0] >= floor])
        bases.append(base)
    base, (pixel, *rings) = float(np.median(bases)), np.concatenate(hot, axis=1)
    top = np.stack(rings)
    pairs = np.stack([pixel, *rings], axis=1)[:: -(-pixel.size // MOST_PAIRS) or 1]
    return StandingOut(
        (2 * reach + 1) ** 2 - 1,
        reduce(operator.add, leads),
        _excess(pixel / np.maximum(top, floor / 4), RATIOS, frames),
        tuple(_excess(pixel - a * top, ladder, frames) for a in SLOPES),
        base,
        (pairs + base).astype(np.float32),
    )


def _rings(frame: np.ndarray, reach: int) -> list[np.ndarray]:
    """Maxima of each pixel's ring, and of the larger of two opposite ones along rows, columns."""
    top = ring_maximum(frame, reach)
    rows, columns = (n - 2 * AWAY for n in top.shape)

    def moved(down: int, along: int) -> np.ndarray:
        y, x = AWAY + down, AWAY + along
        return top[y : y + rows, x : x + columns]

    pairs = ((moved(0, AWAY), moved(0, -AWAY)), (moved(AWAY, 0), moved(-AWAY, 0)))
    return [moved(0, 0), *(np.maximum(one, other) for one, other in pairs)]


def _excess(values: np.ndarray, bounds: np.ndarray, frames: int) -> Excess:
    """How many lie beyond each bound: of the own ring, and the mean of the two others."""
    counts = [
        np.bincount(np.searchsorted(bounds, of[of > bounds[0]]), minlength=bounds.size + 1)
        for of in values
    ]
    own, along, down = np.array(counts)[:, ::-1].cumsum(axis=1)[:, ::-1][:, 1:]
    return Excess(bounds, own, (along + down) / 2, frames)
