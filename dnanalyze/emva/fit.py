"""Weighted straight lines, one slope and one intercept a group."""

from __future__ import annotations

import math

import numpy as np

from dnanalyze.analyzers.estimators.arrhenius import misfit
from dnanalyze.analyzers.statistics import Value

AGREES = 0.15  # of a slope: largest difference between all pixels and the typical ones
SURE = 3.0  # standard errors


def line(x: np.ndarray, y: np.ndarray, error: np.ndarray) -> tuple[Value, Value] | None:
    """Intercept and slope of y over x by weighted least squares.

    Standard errors follow from ``error``, widened where the points scatter more than that
    (chi^2 per degree of freedom above 1).

    Parameters
    ----------
    x, y, error : ndarray
        (points,); ``error`` is the standard error of ``y``, above 0.

    Returns
    -------
    (Value, Value) or None
        None for fewer than two different x.
    """
    found = common_slope(x, y, error, np.zeros(x.size, int))
    return None if found is None else (found[0][0], found[1])


def common_slope(
    x: np.ndarray, y: np.ndarray, error: np.ndarray, group: np.ndarray
) -> tuple[list[Value], Value] | None:
    """As `line` with an intercept for each group and one slope.

    Parameters
    ----------
    group : ndarray of int
        (points,); 0, 1, ...

    Returns
    -------
    (list of Value, Value) or None
        Intercepts by group, slope; None where no group has two different x.
    """
    groups = int(group.max()) + 1 if group.size else 0
    if not any(np.ptp(x[group == g]) > 0 for g in range(groups)):
        return None
    scale = float(np.ptp(x))
    design = np.zeros((x.size, groups + 1))
    design[np.arange(x.size), group] = 1.0
    design[:, -1] = x / scale
    weighted = design / error[:, None]
    inverse = np.linalg.inv(weighted.T @ weighted)
    solution = inverse @ (weighted.T @ (y / error))
    wider = misfit((y - design @ solution) / error, groups + 1)
    se = np.sqrt(np.diag(inverse)) * wider
    values = [Value(float(v), float(s)) for v, s in zip(solution, se, strict=True)]
    slope = Value(values[-1].value / scale, values[-1].se / scale)
    return values[:-1], slope


def alike(every: Value, typical: Value) -> bool:
    """Whether a slope of all pixels is that of typical ones, which hits and blinking leave alone.

    Within 15 % and 3 standard errors.
    """
    apart = abs(every.value - typical.value)
    return apart <= AGREES * abs(every.value) + SURE * math.hypot(every.se, typical.se)
