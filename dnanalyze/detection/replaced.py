"""Pixels that are in every frame what their neighbours say: replaced, site by site.

For each way in which correctors interpolate (means and medians of 2, 4, 8 or 24 neighbours,
copies), a site matches where the residual stays within one step in all frames though the pixel
itself varies. The control counts matches with the same interpolation of a ring a few pixels away,
which has the same noise, rounding, clipping and line structure, so that no model of the noise is
needed; a gradient, such as glow, is taken off with the ring on the opposite side. Noise that
neighbours share (hum, 1/f) lets more of them match their own ring by chance; but then more match in
all frames but one as well, which replaced sites do not. A pixel that is clipped or saturated in any
frame is left out: in a bright spot, or a dark one, its neighbours are so as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

import numpy as np
from numba import njit

RULES = (
    "mean of 4", "mean of 8", "mean of left and right", "mean of above and below",
    "median of 8", "fifth of 8", "median of 4", "largest of 8", "copy of a neighbour",
    "mean of 24",
)  # fmt: skip
CONTROLS = np.array([(0, 4), (4, 0)])  # along the row, along the column


@dataclass(frozen=True)
class Replaced:
    """Sites that match, rule by rule."""

    own: np.ndarray  # (rules,), sites that match their own neighbours
    # (rules,), count over displaced rings, along rows or along columns, what is more (noise that is
    # correlated along one of them is shared only there).
    control: np.ndarray
    # (rules,), the same of sites that match in all frames but one.
    almost: np.ndarray
    almost_control: np.ndarray
    sites: np.ndarray  # (n, 3): rule, row, column of the own matches
    tried: int  # sites looked at
    frames: int

    def __add__(self, other: Replaced) -> Replaced:
        return Replaced(
            self.own + other.own, self.control + other.control,
            self.almost + other.almost, self.almost_control + other.almost_control,
            np.concatenate([self.sites, other.sites]), self.tried + other.tried, self.frames,
        )  # fmt: skip


@njit(cache=True, nogil=True)
def _references(
    f: np.ndarray, y: int, x: int, v: float, reach: float, out: np.ndarray, ring: np.ndarray
) -> None:
    """What each rule but the last makes of the ring around (y, x), into ``out``.

    Medians of 8 are worked out only where ``v`` may be one: no more than 4 of the ring lie
    farther than ``reach`` below it, or above; elsewhere they are infinite.
    """
    up, down, left, right = f[y - 1, x], f[y + 1, x], f[y, x - 1], f[y, x + 1]
    ring[0] = f[y - 1, x - 1]
    ring[1] = up
    ring[2] = f[y - 1, x + 1]
    ring[3] = left
    ring[4] = right
    ring[5] = f[y + 1, x - 1]
    ring[6] = down
    ring[7] = f[y + 1, x + 1]
    cross = up + down + left + right
    total = 0.0
    below = above = 0
    top = ring[0]
    for i in range(8):
        total += ring[i]
        below += ring[i] < v - reach
        above += ring[i] > v + reach
        top = max(top, ring[i])
    out[0] = cross / 4
    out[1] = total / 8
    out[2] = (left + right) / 2
    out[3] = (up + down) / 2
    out[4] = out[5] = np.inf
    out[6] = (cross - max(up, down, left, right) - min(up, down, left, right)) / 2
    out[7] = top
    if below > 4 or above > 4:
        return
    for i in range(1, 8):  # insertion sort
        w = ring[i]
        j = i - 1
        while j >= 0 and ring[j] > w:
            ring[j + 1] = ring[j]
            j -= 1
        ring[j + 1] = w
    out[4] = (ring[3] + ring[4]) / 2
    out[5] = ring[4]


@njit(cache=True, nogil=True)
def _match(
    stack: np.ndarray, squares: np.ndarray, level: np.ndarray, shifts: np.ndarray,
    step: float, slack: float, least: float, bottom: float, top: float, limit: int,
):  # fmt: skip
    """Matches of each rule, in all frames and in all but one; own ring first, then displaced ones.

    ``squares``: sums over 5x5 pixels; ``level``: their mean over pixels and frames.
    """
    frames, h, w = stack.shape
    rules = 10
    counts = np.zeros((2, shifts.shape[0], rules), np.int64)
    sites = np.empty((limit, 3), np.int64)
    kept = 0
    low = np.empty(rules)
    high = np.empty(rules)
    misses = np.empty(rules, np.int64)
    copies = np.empty(4, np.int64)
    ref = np.empty(rules)
    ring = np.empty(8)
    margin = 2 + np.abs(shifts).max()
    tried = 0
    for y in range(margin, h - margin):
        for x in range(margin, w - margin):
            largest, smallest = stack[:, y, x].max(), stack[:, y, x].min()
            if smallest <= bottom or largest >= top or largest - smallest < least:
                continue
            tried += 1
            for s in range(shifts.shape[0]):
                oy, ox = y + shifts[s, 0], x + shifts[s, 1]
                # a gradient: half of what lies between the ring and that on the opposite side
                off = (level[y - shifts[s, 0], x - shifts[s, 1]] - level[oy, ox]) / 2
                off = round(off / step) * step if step > 0 else off
                misses[:] = 0
                copies[:] = 0
                low[:] = np.inf
                high[:] = -np.inf
                for k in range(frames):
                    v = stack[k, y, x] - off
                    f = stack[k]
                    _references(f, oy, ox, v, step + slack, ref, ring)
                    ref[9] = (squares[k, oy, ox] - f[oy, ox]) / 24
                    some = False
                    for r in range(rules):
                        if misses[r] > 1 or r == 8:
                            continue
                        d = v - ref[r]
                        if r == 5 or r == 7:  # order statistics are copied exactly
                            fits = abs(d) <= slack
                        else:
                            least_d, most_d = min(low[r], d), max(high[r], d)
                            fits = (
                                least_d > -step - slack
                                and most_d < step + slack
                                and most_d - least_d <= step + slack
                            )
                            if fits:
                                low[r], high[r] = least_d, most_d
                        misses[r] += not fits
                        some = some or misses[r] < 2
                    if misses[8] < 2:
                        copies[0] += abs(v - f[oy, ox - 1]) > slack
                        copies[1] += abs(v - f[oy, ox + 1]) > slack
                        copies[2] += abs(v - f[oy - 1, ox]) > slack
                        copies[3] += abs(v - f[oy + 1, ox]) > slack
                        misses[8] = copies.min()
                        some = some or misses[8] < 2
                    if not some:
                        break
                for r in range(rules):
                    if misses[r] < 2:
                        counts[misses[r], s, r] += 1
                        if misses[r] == 0 and s == 0 and kept < limit:
                            sites[kept, 0] = r
                            sites[kept, 1] = y
                            sites[kept, 2] = x
                            kept += 1
    return counts, sites[:kept], tried


def _sums(stack: np.ndarray) -> np.ndarray:
    """Of 5x5 pixels around each; exact for integers below 2^19; zero near the edges."""
    total = np.zeros_like(stack)
    for frame, sums in zip(stack, total, strict=True):
        rows = reduce(np.add, (frame[:, k : frame.shape[1] - 4 + k] for k in range(5)))
        columns = (rows[k : len(rows) - 4 + k] for k in range(5))
        sums[2:-2, 2:-2] = reduce(np.add, columns)
    return total


def replaced(
    stack: np.ndarray, step: float, noise: float, bottom: float = -np.inf, top: float = np.inf
) -> Replaced:
    """Look for replaced sites in three or more raw frames of one plane, (frames, rows, columns).

    ``step``: spacing of the recorded values, 0 where they are not quantised; ``noise``: temporal
    standard deviation of a typical pixel. Values at or below ``bottom`` are clipped, at or above
    ``top`` saturated; the highest of all are left out in any case. All in DN.
    """
    slack = 1e-3 * (step or noise)
    shifts = np.concatenate([[(0, 0)], CONTROLS])
    least = max(2 * step, 0.1 * noise)
    squares = _sums(stack)
    level = squares.mean(axis=0) / 25
    counts, sites, tried = _match(
        stack, squares, level, shifts, step, slack, least, bottom, min(top, stack.max()), 1 << 16
    )
    whole, but_one = counts
    return Replaced(
        whole[0], whole[1:].max(axis=0), but_one[0], but_one[1:].max(axis=0),
        sites, tried, len(stack),
    )  # fmt: skip
