"""Filters that act on some rows only, such as those with phase-detection pixels.

Per row, how often a pixel stands above or below its two neighbours in the same row: 1/3 each for
exchangeable
pixels, whatever the noise of that row. Folded over periods, a phase that departs from the others
is filtered.
Neighbours are two columns away, of the same colour on a mosaic; and one column away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from dnanalyze.detection.neighbours import exceedances
from dnanalyze.robust import robust_deviation

PERIODS = range(2, 17)
SPREAD = 0.385  # sd of the mean of both fractions x sqrt(pixels), relative to 1/3, by simulation


@dataclass(frozen=True)
class RowPhase:
    """The row phase that departs most.

    Parameters
    ----------
    period, phase : int
        Rows; phase counts from the first row.
    effect : float
        1 - (local extremes in those rows over the others'); positive where they are smoother.
    z : float
        In standard errors.
    one_sided : bool
        Only the maxima are rarer: a correction of hot pixels, not a smoothing.
    tried : int
        Phases looked at.
    freedom : float
        Degrees of freedom of the scatter of the rows.
    """

    period: int
    phase: int
    effect: float
    z: float
    one_sided: bool
    tried: int
    freedom: float = np.inf

    @property
    def p(self) -> float:
        """Of this phase alone."""
        return float(stats.t.sf(self.z, self.freedom))


def extremes_by_row(images: np.ndarray, step: int) -> tuple[np.ndarray, np.ndarray]:
    """Local maxima, and minima, of each row among neighbours ``step`` columns away, x 3 /
    pixels.
    """
    none = np.array([0, 0])
    sides = np.array([-step, step])
    above = np.zeros(images.shape[1])
    below = np.zeros(images.shape[1])
    for image in images:
        up, down = exceedances(image, none, sides)
        above += up
        below += down
    pixels = images.shape[0] * (images.shape[2] - 2 * step)
    return 3 * above / pixels, 3 * below / pixels


def row_phase(images: np.ndarray) -> RowPhase:
    """Look at images (n, rows, columns) of noise without ties; None departs: the largest by
    chance.
    """
    rows = images.shape[1]
    best = RowPhase(1, 0, 0.0, 0.0, False, 1)
    tried = 0
    for step in (1, 2):
        maxima, minima = extremes_by_row(images, step)
        share = (maxima + minima) / 2
        scatter = max(
            robust_deviation(share),
            SPREAD / np.sqrt(images.shape[0] * images.shape[2]),
        )
        for period in PERIODS:
            for phase in range(period):
                inside = np.arange(rows) % period == phase
                n, m = int(inside.sum()), int((~inside).sum())
                if n < 6:
                    continue
                tried += 1
                others = float(np.median(share[~inside]))
                difference = others - float(np.median(share[inside]))
                z = difference / (1.25 * scatter * np.sqrt(1 / n + 1 / m))
                if z > best.z:
                    up, down = (
                        float(np.median(s[~inside]) - np.median(s[inside]))
                        for s in (maxima, minima)
                    )
                    best = RowPhase(period, phase, difference / others, z, up > 3 * abs(down), 0)
    # a scatter from the median of N absolute deviations has a relative variance of 1.36 / N
    return replace(best, tried=tried, freedom=rows / 2.7)
