"""What neighbouring pixels share of the shot noise, as a part of the system gain.

Where capacitance couples pixels after their charge was counted, or a filter averages them, a
pixel's temporal variance lacks what it shares with its neighbours. Variance and covariances with
all neighbours together are that of the charge (Moore, Ninkov, Forrest, Opt. Eng. 45, 076402, 2006;
Downing et al., Proc. SPIE 6276, 627609, 2006). Read noise that neighbours share does not grow with
the signal, and is in the intercept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dnanalyze.analyzers.statistics import SettingStatistics, Value
from dnanalyze.emva.fit import SURE, common_slope

# Neighbours at each lag of the curve "noise_correlation" (10, 01, 11, 20, 02).
NEAR = np.array([2.0, 2.0, 4.0, 0.0, 0.0])
FAR = np.array([0.0, 0.0, 0.0, 2.0, 2.0])
# Of a pixel's charge a is in each adjacent one. Pixels two apart share a/2 of what adjacent ones
# do: 0.03 in all at a = 0.05, where a filter with the weights 1, 2, 1 gives 0.15.
FAR_SHARE = 0.05


@dataclass(frozen=True)
class Shared:
    """Slopes of the covariances over the mean dark signal, DN/e-.

    Parameters
    ----------
    near, far : Value
        Of adjacent pixels, and of those two apart in a row or a column.
    """

    near: Value
    far: Value

    @property
    def filtered(self) -> bool:
        """Whether pixels two apart share noise, as coupled ones do not."""
        return _clear(self.far) and abs(self.far.value) > FAR_SHARE * abs(self.near.value)

    @property
    def coupled(self) -> bool:
        """Whether adjacent pixels share noise that grows with the signal."""
        return _clear(self.near)


def _clear(slope: Value) -> bool:
    return abs(slope.value) > SURE * slope.se


def covariances(setting: SettingStatistics, variance: float) -> tuple[float, float, float, float]:
    """Sums of the covariances of typical pixels with near and with far neighbours, DN^2.

    Parameters
    ----------
    setting : SettingStatistics
        One operating point.
    variance : float
        Temporal variance of its typical pixels, DN^2.

    Returns
    -------
    tuple of float
        Near sum and its standard error, far sum and its standard error; NaN where the correlations
        are not known.
    """
    found = setting.curves.get("noise_correlation")
    if found is None or len(found) != NEAR.size:
        return (np.nan,) * 4
    sums = [(float(w @ found[:, 0]), float(np.hypot.reduce(w * found[:, 1]))) for w in (NEAR, FAR)]
    (near, near_error), (far, far_error) = sums
    return variance * near, variance * near_error, variance * far, variance * far_error


def shared(level: np.ndarray, sums: np.ndarray, group: np.ndarray) -> Shared | None:
    """How the covariances grow with the level.

    Parameters
    ----------
    level : ndarray
        (points,), DN.
    sums : ndarray
        (points, 4), those of `covariances`.
    group : ndarray of int
        (points,); each has an intercept of its own.

    Returns
    -------
    Shared or None
        None where they are not known, or no point is left to check the lines.
    """
    if np.isnan(sums).any() or len(level) < int(group.max(initial=0)) + 3:
        return None
    lines = [common_slope(level, sums[:, k], sums[:, k + 1], group) for k in (0, 2)]
    if lines[0] is None or lines[1] is None:
        return None
    return Shared(lines[0][1], lines[1][1])
