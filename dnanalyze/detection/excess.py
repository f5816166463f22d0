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

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dnanalyze.detection.ring import ring_maximum
from dnanalyze.significance import CERTAIN

AWAY = 8  # pixels to the rings of the control: along the row and the column, of the same colour
LADDER = np.concatenate([np.arange(0, 8, 0.25), np.geomspace(8, 4000, 64)])  # in units of the noise
RATIOS = np.geomspace(1.0, 20.0, LADDER.size)  # crosstalk of 2 % forbids more than 42 by itself
# Of rules that ask for a ratio and a threshold
SLOPES = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
MOST_PIXELS = 1 << 15  # hot ones, kept of all frames


@dataclass(frozen=True)
class Excess:
    """Counts of pixels that exceed their neighbours' maximum by more than each bound."""

    bounds: np.ndarray  # DN, or ratios
    # Over so many frames, in each of which a hot pixel counts; the control's is the mean over the
    # displaced rings.
    own: np.ndarray
    control: np.ndarray
    frames: float


@dataclass(frozen=True)
class StandingOut:
    """Pixels that stand out of their frame, and how far out of the largest of their neighbours."""

    neighbours: int  # 8 or 24
    noise: float  # DN, by which the ladder of bounds is scaled
    base: float  # median of the frames, the lowest of several planes, DN
    difference: Excess  # x - max, DN, of pixels above the frame's median
    # (n, 5), DN as recorded: pixels `CERTAIN` above the median of their frame, the largest of their
    # own ring, the larger of two rings on opposite sides along rows, along columns, and that
    # median; of so many frames.
    pixels: np.ndarray
    frames: float

    @property
    def ratio(self) -> Excess:
        """(x - median) / (max - median)."""
        pixel, *rings = self._above
        top = np.maximum(rings, CERTAIN * self.noise / 4)
        return Excess(RATIOS, *_beyond(pixel / top, RATIOS), self.frames)

    def along(self, slope: float) -> Excess:
        """(x - median) - slope (max - median), DN."""
        pixel, *rings = self._above
        bounds = LADDER * self.noise
        return Excess(bounds, *_beyond(pixel - slope * np.array(rings), bounds), self.frames)

    @property
    def _above(self) -> np.ndarray:
        """Pixels and their rings above the median, (4, n)."""
        return (self.pixels[:, :4] - self.pixels[:, 4:]).T


def standing_out(
    planes: Sequence[np.ndarray],
    reach: int,
    noise: float,
    ceiling: float = np.inf,
    replaced: Sequence[np.ndarray] = (),
) -> StandingOut:
    """Pixels that stand out in stacks of frames as recorded.

    Parameters
    ----------
    planes : sequence of ndarray
        (frames, rows, columns) each, DN: the frame, or its colours.
    reach : int
        1: 8 neighbours, 2: 24.
    noise : float
        Of a pixel, DN.
    ceiling : float
        Pixels at or above are saturated and left out.
    replaced : sequence of ndarray, optional
        (n, 2) of each plane, rows and columns of sites that look replaced. Pixels beside them are
        left out: a corrector replaces a pixel but not its fainter hot neighbour, which then stands
        alone.
    """
    margin, frames, ladder = reach + AWAY, len(planes[0]), LADDER * noise
    bases, found, counts = [], [], np.zeros((2, ladder.size))
    for number, stack in enumerate(planes):
        free = np.ones(stack.shape[1:], bool)
        for y, x in replaced[number] if len(replaced) else ():
            free[max(0, y - reach) : y + reach + 1, max(0, x - reach) : x + reach + 1] = False
        free = free[margin:-margin, margin:-margin]
        for frame in stack:
            base = np.median(frame[::5, ::5])
            pixel = frame[margin:-margin, margin:-margin]
            seen = free & (pixel >= base) & (pixel < ceiling)
            of_pixels = np.stack([of[seen] for of in (pixel, *_rings(frame, reach))])
            counts += _beyond(of_pixels[0] - of_pixels[1:], ladder)
            found.append(of_pixels[:, of_pixels[0] >= base + CERTAIN * noise].T)
            bases.append(base)
    medians = np.repeat(bases, [len(f) for f in found])[:, None]
    pixels = np.hstack([np.concatenate(found), medians]).astype(np.float32)
    every = max(1, -(-len(pixels) // MOST_PIXELS))
    return StandingOut(
        (2 * reach + 1) ** 2 - 1, noise, float(min(bases)),
        Excess(ladder, counts[0], counts[1], frames), pixels[::every], frames / every,
    )  # fmt: skip


def _rings(frame: np.ndarray, reach: int) -> list[np.ndarray]:
    """Maxima of each pixel's ring, and of the larger of two opposite ones along rows, columns."""
    top = ring_maximum(frame, reach)
    rows, columns = (n - 2 * AWAY for n in top.shape)

    def moved(down: int, along: int) -> np.ndarray:
        y, x = AWAY + down, AWAY + along
        return top[y : y + rows, x : x + columns]

    pairs = ((moved(0, AWAY), moved(0, -AWAY)), (moved(AWAY, 0), moved(-AWAY, 0)))
    return [moved(0, 0), *(np.maximum(one, other) for one, other in pairs)]


def _beyond(values: np.ndarray, bounds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How many lie beyond each bound: of the own ring, and the mean of the two others."""
    own, along, down = (
        np.bincount(np.searchsorted(bounds, of[of > bounds[0]]), minlength=bounds.size + 1)
        for of in values
    )
    counts = np.array([own, (along + down) / 2])
    own, control = counts[:, ::-1].cumsum(axis=1)[:, ::-1][:, 1:]
    return own, control
