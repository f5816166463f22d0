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

from dataclasses import dataclass

import numpy as np
from numba import njit

from dnanalyze.significance import CERTAIN

CONTROLS = ((0, 8), (8, 0))  # and opposite: same row or column, same colour
LADDER = np.concatenate([np.arange(0, 8, 0.25), np.geomspace(8, 4000, 64)])  # in units of the noise
RATIOS = np.geomspace(1.0, 20.0, LADDER.size)  # crosstalk of 2 % forbids more than 42 by itself
MOST_PAIRS = 1 << 13  # kept of a stack
SLOPES = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
RATIO = 0.0


@dataclass(frozen=True)
class Excess:
    """Counts of pixels that exceed their neighbours' maximum by more than each bound.

    Parameters
    ----------
    bounds : ndarray
        DN, or ratios.
    own, control : ndarray
        Count over all frames; the control's is the mean over the displaced rings.
    frames : int
        Frames that went in; a hot pixel counts in each.
    """

    bounds: np.ndarray
    own: np.ndarray
    control: np.ndarray
    frames: int

    def __add__(self, other: Excess) -> Excess:
        return Excess(
            self.bounds, self.own + other.own, self.control + other.control,
            max(self.frames, other.frames),
        )  # fmt: skip


@njit(cache=True, nogil=True)
def _survival(
    frame: np.ndarray, top: np.ndarray, skip: np.ndarray, reach: int, shifts: np.ndarray,
    rules: np.ndarray, bounds: np.ndarray, base: float, floor: float, ceiling: float,
) -> np.ndarray:  # fmt: skip
    """Histograms over ``bounds`` of what each rule bounds, of own and displaced maxima.

    The pixels looked at lie ``floor`` above ``base``. A rule is a slope a of x - a max, both above
    ``base``; ``RATIO`` stands for x / max.
    """
    h, w = frame.shape
    counts = np.zeros((rules.size, 2, bounds.shape[1] + 1), np.float64)
    margin = reach + np.abs(shifts).max()
    weight = 1.0 / shifts.shape[0]
    for y in range(margin, h - margin):
        for x in range(margin, w - margin):
            v = frame[y, x] - base
            if v < floor or frame[y, x] >= ceiling or skip[y, x]:
                continue
            for s in range(-1, shifts.shape[0]):
                if s < 0:
                    m = top[y - reach, x - reach] - base
                else:
                    oy, ox = shifts[s]
                    one = top[y + oy - reach, x + ox - reach]
                    m = max(one, top[y - oy - reach, x - ox - reach]) - base
                for k in range(rules.size):
                    e = v / max(m, floor / 4) if rules[k] == RATIO else v - rules[k] * m
                    if e > bounds[k, 0]:  # bounds below e: 0 .. n - 1
                        n = np.searchsorted(bounds[k], e)
                        counts[k, min(s + 1, 1), n] += 1.0 if s < 0 else weight
    return counts


def _pairs(
    frame: np.ndarray, top: np.ndarray, skip: np.ndarray, reach: int,
    base: float, floor: float, ceiling: float,
) -> np.ndarray:  # fmt: skip
    """Pixels ``floor`` above ``base`` with the maxima of their own and of displaced rings, DN."""
    margin = reach + max(max(c) for c in CONTROLS)
    inner = (slice(margin, -margin), slice(margin, -margin))
    hot = (frame[inner] >= base + floor) & (frame[inner] < ceiling) & ~skip[inner]
    y, x = (n + margin for n in np.nonzero(hot))
    sides = [
        np.maximum(
            top[y + dy - reach, x + dx - reach], top[y - dy - reach, x - dx - reach]
        ) for dy, dx in CONTROLS
    ]  # fmt: skip
    values = [frame[y, x], top[y - reach, x - reach], *sides]
    return np.stack(values, axis=1).astype(np.float32)


def without_transients(stack: np.ndarray, noise: float, sigmas: float = CERTAIN) -> np.ndarray:
    """Values far from the pixel's median over time replaced by it: hits and blinking, not hot
    pixels.

    As given where there are fewer than 3 frames.
    """
    if stack.shape[0] < 3:
        return stack
    middle = np.sort(stack, axis=0)[stack.shape[0] // 2]
    return np.where(np.abs(stack - middle) > np.float32(sigmas * noise), middle, stack)


@dataclass(frozen=True)
class StandingOut:
    """How far pixels stand out of the largest of their neighbours, in three ways.

    Parameters
    ----------
    neighbours : int
        8 or 24.
    difference : Excess
        x - max, DN, of pixels above the frame's median.
    ratio : Excess
        (x - median) / (max - median), of pixels 6 units above the median.
    sloped : tuple of Excess
        (x - median) - a (max - median), DN, of the same pixels, for each a of ``SLOPES``.
    base : float
        Median of the frames, DN.
    pairs : ndarray
        (n, 4), some of the same pixels, DN as recorded, with the largest of their own ring and
        the larger of two rings on opposite sides, along rows, along columns.
    """

    neighbours: int
    difference: Excess
    ratio: Excess
    sloped: tuple[Excess, ...]
    base: float
    pairs: np.ndarray

    def along(self, slope: float) -> Excess:
        """(x - median) - slope (max - median) for one of ``SLOPES``."""
        return self.sloped[SLOPES.index(slope)]

    def __add__(self, other: StandingOut) -> StandingOut:
        sloped = tuple(a + b for a, b in zip(self.sloped, other.sloped, strict=True))
        return StandingOut(
            self.neighbours, self.difference + other.difference, self.ratio + other.ratio, sloped,
            min(self.base, other.base), np.concatenate([self.pairs, other.pairs]),
        )  # fmt: skip


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
    from dnanalyze.detection.neighbours import ring_maximum

    ladder = LADDER * unit
    plain = np.array([1.0]), ladder[None], 0.0
    hot = (
        np.array([RATIO, *SLOPES]),
        np.concatenate([RATIOS[None], np.tile(ladder, (len(SLOPES), 1))]),
        CERTAIN * unit,
    )
    counts = [np.zeros((len(rules), 2, LADDER.size + 1)) for rules, _, _ in (plain, hot)]
    bases, pairs = [], []
    skip = np.zeros(stack.shape[1:], bool)
    for y, x in replaced if replaced is not None else ():
        skip[max(0, y - reach) : y + reach + 1, max(0, x - reach) : x + reach + 1] = True
    for frame in stack:
        top = ring_maximum(frame, reach)
        bases.append(float(np.median(frame[::5, ::5])))
        pairs.append(_pairs(frame, top, skip, reach, bases[-1], CERTAIN * unit, ceiling))
        for count, (rules, bounds, floor) in zip(counts, (plain, hot), strict=True):
            count += _survival(
                frame, top, skip, reach, np.array(CONTROLS),
                rules, bounds, bases[-1], floor, ceiling,
            )  # fmt: skip
    above = [count[..., ::-1].cumsum(axis=-1)[..., ::-1][..., 1:] for count in counts]
    sums = [
        Excess(bounds[k], own_and_control[k, 0], own_and_control[k, 1], len(stack))
        for own_and_control, (rules, bounds, _) in zip(above, (plain, hot), strict=True)
        for k in range(rules.size)
    ]
    return StandingOut(
        (2 * reach + 1) ** 2 - 1,
        sums[0],
        sums[1],
        tuple(sums[2:]),
        float(np.median(bases)),
        np.concatenate([p[:: -(-len(stack) * len(p) // MOST_PAIRS) or 1] for p in pairs]),
    )
