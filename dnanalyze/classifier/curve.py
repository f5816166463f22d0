"""Area under the ROC curve with a standard error that knows rows, columns and places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Two folds that exchange training and test agree by chance in sign: of two independent normal
# differences d and e the one gives sign(d) e, the other sign(e) d, correlated by E|d| E|e| = 2/pi.
EXCHANGED = 1.0 + 2.0 / np.pi


@dataclass(frozen=True)
class Area:
    """Area under the ROC curve.

    Parameters
    ----------
    value : float
        0.5 where measured and simulated cannot be told apart.
    influence : ndarray
        (rows of patches, columns of patches): by how much each place moves the value.
    """

    value: float
    influence: np.ndarray

    @property
    def se(self) -> float:
        """Standard error.

        Patches of one row or column of patches share what the sensor draws once per row or column,
        so their influences are summed first (Cameron, Gelbach and Miller 2011).
        """
        rows, columns, both = (
            _scatter(self.influence.sum(axis=axis)) for axis in (1, 0, ())
        )  # fmt: skip
        variance = max(rows + columns - both, rows, columns, both)
        return float(np.sqrt(EXCHANGED * variance))


def _scatter(sums: np.ndarray) -> float:
    """Sum of squares of clusters, corrected for their number."""
    count = sums.size
    return float((sums**2).sum() * count / max(1, count - 1))


def area(
    measured: np.ndarray, simulated: np.ndarray, places: np.ndarray, grid: tuple[int, int]
) -> Area:
    """Area of one fold.

    Parameters
    ----------
    measured, simulated : ndarray
        Scores of the test patches.
    places : ndarray of int
        (patches, 2): row and column of each in the grid, of measured and simulated alike.
    grid : tuple of int
        (rows, columns) of patches.

    Returns
    -------
    Area
        By DeLong, DeLong and Clarke-Pearson 1988: each patch moves the area by the share of the
        other kind that it exceeds.
    """
    above = _share_below(measured, simulated)
    under = 1.0 - _share_below(simulated, measured)
    value = float(above.mean())
    influence = np.zeros(grid)
    moved = (above - value) / len(measured) + (under - value) / len(simulated)
    np.add.at(influence, (places[:, 0], places[:, 1]), moved)
    return Area(value, influence)


def mean_area(areas: list[Area]) -> Area:
    """Mean of areas over the same grid."""
    return Area(
        float(np.mean([a.value for a in areas])), np.mean([a.influence for a in areas], axis=0)
    )


def _share_below(these: np.ndarray, those: np.ndarray) -> np.ndarray:
    """For each of these the share of those that lie below, ties counted half."""
    order = np.sort(those)
    left, right = (np.searchsorted(order, these, side) for side in ("left", "right"))
    return (left + right) / (2.0 * len(order))
