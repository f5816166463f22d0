"""How far pixels stand out of their neighbours: a dynamic correction leaves a cliff.

A dynamic corrector, a clamp and a ratio rule all forbid a pixel to stand out of its *own*
neighbours by
more than some bound, and know nothing of neighbours elsewhere. So the excess x - max(neighbours)
is held
against the excess of the same pixels over rings of neighbours a few pixels away (the control).
Where
pixels are exchangeable at that scale the control is no more frequent, whatever the marginal; above
the
threshold of a corrector only the control has any. The control takes the larger of two rings on
opposite sides, so that a gradient cannot feed it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

CONTROLS = ((0, 8), (8, 0))  # and opposite: same row or column, same colour
RATIOS = np.geomspace(1.0, 20.0, 36)  # crosstalk of 2 % forbids ratios above 42 by itself
LADDER = np.concatenate([np.arange(0, 8, 0.25), np.geomspace(8, 4000, 64)])  # in units of the noise


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
    frame: np.ndarray, top: np.ndarray, reach: int, shifts: np.ndarray,
    bounds: np.ndarray, base: float, ratio: bool, floor: float, ceiling: float,
) -> np.ndarray:  # fmt: skip
    """Histogram over ``bounds`` of the excess (or ratio) over own and displaced maxima."""
    h, w = frame.shape
    n = bounds.size
    found = np.zeros((2, n + 1), np.float64)
    margin = reach + np.abs(shifts).max()
    weight = 1.0 / shifts.shape[0]
    for y in range(margin, h - margin):
        for x in range(margin, w - margin):
            v = frame[y, x]
            if v >= ceiling or v - base < floor:
                continue
            for s in range(-1, shifts.shape[0]):
                if s < 0:
                    m = top[y - reach, x - reach]
                else:
                    oy, ox = shifts[s]
                    m = max(
                        top[y + oy - reach, x + ox - reach], top[y - oy - reach, x - ox - reach]
                    )
                if ratio:
                    e = (v - base) / max(m - base, floor / 4)
                else:
                    e = v - m
                if e > bounds[0]:
                    k = np.searchsorted(bounds, e)  # bounds below e: 0 .. k - 1
                    if s < 0:
                        found[0, k] += 1
                    else:
                        found[1, k] += weight
    return found


def without_transients(stack: np.ndarray, noise: float, sigmas: float = 6.0) -> np.ndarray:
    """Values far from the pixel's median over time replaced by it: hits and blinking, not hot
    pixels.

    As given where there are fewer than 3 frames.
    """
    if stack.shape[0] < 3:
        return stack
    middle = np.sort(stack, axis=0)[stack.shape[0] // 2]
    return np.where(np.abs(stack - middle) > np.float32(sigmas * noise), middle, stack)


def excess(
    stack: np.ndarray, reach: int, unit: float, ceiling: float = np.inf
) -> tuple[Excess, Excess]:
    """Own and control counts over a stack of frames as recorded: of the excess, and of the ratio.

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

    Returns
    -------
    above, ratio : Excess
        Bounds on x - max in DN; on (x - median) / (max - median) of pixels 6 units above the
        median.
    """
    from dnanalyze.detection.neighbours import ring_extremes

    bounds = (LADDER * unit, RATIOS)
    counts = [np.zeros((2, b.size + 1)) for b in bounds]
    for frame in stack:
        top, _ = ring_extremes(frame, reach)
        base = float(np.median(frame[::5, ::5]))
        for is_ratio in (False, True):
            floor = 6 * unit if is_ratio else -np.inf
            counts[is_ratio] += _survival(
                frame,
                top,
                reach,
                np.array(CONTROLS),
                bounds[is_ratio],
                base,
                is_ratio,
                floor,
                ceiling,
            )
    above = [c[:, ::-1].cumsum(axis=1)[:, ::-1][:, 1:] for c in counts]
    difference, ratio = (
        Excess(b, a[0], a[1], len(stack)) for b, a in zip(bounds, above, strict=True)
    )
    return difference, ratio


@dataclass(frozen=True)
class Scatter:
    """A pixel against the largest of its 8 neighbours, both above the median.

    Parameters
    ----------
    counts : ndarray
        (bins, bins): pixel value by neighbours' maximum.
    edges : ndarray
        (bins + 1,), DN above the median.
    """

    counts: np.ndarray
    edges: np.ndarray


def scatter(frame: np.ndarray, unit: float, bins: int = 64) -> Scatter:
    """Histogram that practitioners know: unfiltered, hot pixels make a vertical arm."""
    from dnanalyze.detection.neighbours import ring_extremes

    top, _ = ring_extremes(frame, 1)
    base = float(np.median(frame[::5, ::5]))
    inner = frame[1:-1, 1:-1] - base
    reach = max(12 * unit, float(np.quantile(inner[::3, ::3], 0.9995)))
    edges = np.linspace(-4 * unit, reach, bins + 1)
    counts, _, _ = np.histogram2d(
        np.clip(inner.ravel(), edges[0], edges[-1]),
        np.clip((top - base).ravel(), edges[0], edges[-1]),
        bins=(edges, edges),
    )
    return Scatter(counts.astype(np.int64), edges)
