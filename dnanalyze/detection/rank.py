"""How often a pixel is the largest, or the smallest, of its neighbourhood: 1/9, 1/13, 1/25.

For exchangeable pixels P(x above its n neighbours) = 1/(n + 1) exactly, whatever the marginal. Any
smoothing
makes local extremes rarer; a correction of hot pixels alone makes only the maxima rarer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dnanalyze.detection.neighbours import exceedances

NEIGHBOURS = {
    8: [(y, x) for y in (-1, 0, 1) for x in (-1, 0, 1) if (y, x) != (0, 0)],
    12: [(y, x) for y in range(-2, 3) for x in range(-2, 3) if 0 < abs(y) + abs(x) <= 2],
    24: [(y, x) for y in range(-2, 3) for x in range(-2, 3) if (y, x) != (0, 0)],
}
SPREAD = {8: 0.157, 12: 0.131, 24: 0.098}  # sd of either fraction x sqrt(pixels), by simulation
BOTH = 0.75  # sd of their mean over that of one


@dataclass(frozen=True)
class Exceedance:
    """Counts of local maxima and minima.

    Parameters
    ----------
    neighbours : int
        8, 12 or 24.
    above, below : int
        Pixels above, and below, all their neighbours.
    pixels : int
        Pixels looked at, over all images.
    """

    neighbours: int
    above: int
    below: int
    pixels: int

    def __add__(self, other: Exceedance) -> Exceedance:
        return Exceedance(
            self.neighbours,
            self.above + other.above,
            self.below + other.below,
            self.pixels + other.pixels,
        )

    @property
    def extremes(self) -> float:
        """Local extremes over those of exchangeable pixels; 1 for no filter."""
        return (self.neighbours + 1) * (self.above + self.below) / (2 * self.pixels)

    @property
    def se(self) -> float:
        """Standard error of ``extremes`` for exchangeable pixels."""
        return BOTH * (self.neighbours + 1) * SPREAD[self.neighbours] / float(np.sqrt(self.pixels))


def exceedance(images: np.ndarray, neighbours: int = 8) -> Exceedance:
    """Count in images (n, rows, columns) without ties."""
    offsets = np.array(NEIGHBOURS[neighbours])
    reach = int(np.abs(offsets).max())
    above = below = 0
    for image in images:
        up, down = exceedances(image, offsets[:, 0], offsets[:, 1])
        above += int(up.sum())
        below += int(down.sum())
    n, h, w = images.shape
    return Exceedance(neighbours, above, below, n * (h - 2 * reach) * (w - 2 * reach))
