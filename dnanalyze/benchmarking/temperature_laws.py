"""A figure over temperature as a law, so that sensors can be compared where they were not measured.

Candidate laws are fitted by weighted least squares and averaged by their evidence (BIC weights,
Burnham and Anderson, 2002), so that the uncertainty holds what the choice of law costs; it grows
with the distance to the measured temperatures.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dnanalyze.thermal import KELVIN, activation

LEAST_RELATIVE = 0.02  # no law of a sensor holds better than that
ENERGY = 0.65  # eV, of dark currents
ENERGIES = (0.5, 0.65, 0.9, 1.2)


@dataclass(frozen=True)
class Reading:
    """A figure at one temperature: C, value, standard error in plain units, and what told it."""

    temperature_c: float
    value: float
    se: float
    statistic: str = ""


@dataclass(frozen=True)
class LawEstimate:
    """A figure at a temperature, from its law.

    Parameters
    ----------
    value, se : float
        Plain units; the error holds sampling, misfit and the choice of the law.
    cost : float
        The error over that of the nearest measured reading: what the common temperature costs.
    outside_c : float
        Distance to the measured temperatures, C; 0 inside.
    """

    value: float
    se: float
    cost: float
    outside_c: float


@dataclass(frozen=True)
class _Fitted:
    """A law linear in its coefficients, y = B(T) c, y the value, its square or its logarithm."""

    name: str
    powers: tuple[tuple[str, float], ...]
    centre: float  # K
    coefficients: np.ndarray
    covariance: np.ndarray
    bic: float

    def at(self, temperature_c: float) -> tuple[float, float]:
        """Logarithm of the figure and its error."""
        row = _basis(self.name, self.powers, np.array([temperature_c + KELVIN]), self.centre)[0]
        y = float(row @ self.coefficients)
        error = math.sqrt(max(float(row @ self.covariance @ row), 0.0))
        if self.name == "log":
            return y, error
        if y <= 0:
            return math.nan, math.nan
        return math.log(y) / 2, error / (2 * y)


def _basis(
    name: str, powers: tuple[tuple[str, float], ...], kelvin: np.ndarray, centre: float
) -> np.ndarray:
    x = activation(kelvin, centre)
    if name == "log":
        return np.stack([x**i for i in range(len(powers))], axis=1)
    return np.stack([np.exp(np.clip(energy * x, -60, 60)) for _, energy in powers], axis=1)


def estimate(
    readings: Sequence[Reading], temperature_c: float, floor: bool = True
) -> LawEstimate | None:
    """A positive figure at a temperature.

    Laws: its logarithm constant, linear or (of a rate) quadratic in 1/T; of a noise also its
    square, a floor and an activated part.

    Parameters
    ----------
    readings : sequence of Reading
        At different temperatures, positive.
    temperature_c : float
        C.
    floor : bool
        A noise, which has a floor that stays in the cold; a dark current has none.

    Returns
    -------
    LawEstimate or None
        None without readings, or from one reading at another temperature.
    """
    known = [r for r in readings if r.value > 0 and math.isfinite(r.value) and math.isfinite(r.se)]
    if not known:
        return None
    kelvin = np.array([r.temperature_c + KELVIN for r in known])
    nearest = min(known, key=lambda r: abs(r.temperature_c - temperature_c))
    gap = abs(nearest.temperature_c - temperature_c)
    if np.unique(kelvin).size < 2:
        return LawEstimate(nearest.value, nearest.se, 1.0, 0.0) if gap < 1.0 else None
    values = np.array([r.value for r in known])
    relative = np.maximum([r.se / r.value for r in known], LEAST_RELATIVE)
    fits = [
        f for f in _fits(kelvin, values, relative, floor) if math.isfinite(f.at(temperature_c)[0])
    ]
    if not fits:
        return None
    bic = np.array([f.bic for f in fits])
    weight = np.exp(-(bic - bic.min()) / 2)
    weight /= weight.sum()
    logs, errors = np.array([f.at(temperature_c) for f in fits]).T
    mean = float(weight @ logs)
    error = math.sqrt(float(weight @ (errors**2 + (logs - mean) ** 2)))
    value = math.exp(mean)
    low, high = kelvin.min() - KELVIN, kelvin.max() - KELVIN
    outside = max(0.0, low - temperature_c, temperature_c - high)
    own = max(nearest.se / nearest.value, 1e-9)
    return LawEstimate(value, value * error, error / own, float(outside))


def _fits(
    kelvin: np.ndarray, values: np.ndarray, relative: np.ndarray, floor: bool
) -> list[_Fitted]:
    """Every law that these readings can tell, with its evidence."""
    centre = 2 / (1 / kelvin.min() + 1 / kelvin.max())
    count = np.unique(kelvin).size
    made = []
    most = 2 if floor and count > 2 else 3  # a parabola would turn a noise up in the cold
    for order in range(1, min(count, most) + 1):
        powers = tuple(("", 0.0) for _ in range(order))
        made.append(_fit("log", powers, centre, kelvin, np.log(values), relative))
    squares, spread = values**2, 2 * relative * values**2
    for energy in ENERGIES if count > 2 and floor else ():
        for times in (1.0, 2.0):
            powers = (("floor", 0.0), ("thermal", times * energy))
            made.append(_fit("square", powers, centre, kelvin, squares, spread))
    return [f for f in made if f is not None]


def _fit(
    name: str,
    powers: tuple[tuple[str, float], ...],
    centre: float,
    kelvin: np.ndarray,
    y: np.ndarray,
    sigma: np.ndarray,
) -> _Fitted | None:
    from scipy.optimize import nnls

    basis = _basis(name, powers, kelvin, centre)
    a, b = basis / sigma[:, None], y / sigma
    if name == "square":
        coefficients, _ = nnls(a, b)
    else:
        coefficients = np.linalg.lstsq(a, b, rcond=None)[0]
    pulls = b - a @ coefficients
    parameters = len(powers) + (name == "square")  # its energy was chosen, too
    freedom = y.size - parameters
    chi2 = float(pulls @ pulls)
    scale = max(1.0, chi2 / freedom) if freedom > 0 else 1.0
    covariance = np.linalg.pinv(a.T @ a) * scale
    log_sigma = np.sum(np.log(sigma / (2 * y))) if name == "square" else np.sum(np.log(sigma))
    bic = chi2 + 2 * float(log_sigma) + parameters * math.log(y.size)
    return _Fitted(name, powers, centre, coefficients, covariance, bic)


def common_temperatures(ranges: Sequence[tuple[float, float]], most: int = 3) -> list[float]:
    """Temperatures at which to compare: inside what most have measured, else midway between.

    Parameters
    ----------
    ranges : sequence of (float, float)
        Coldest and hottest of each sensor, C.
    most : int
        Temperatures at most.
    """
    if not ranges:
        return []
    groups = [[r for r in ranges if r[0] <= start <= r[1]] for start, _ in ranges]
    group = max(groups, key=len)  # those that overlap; the first of the largest
    if len(group) == 1:
        group = list(ranges)
    low, high = max(a for a, _ in group), min(b for _, b in group)
    if high - low < 1.0:
        return [float(round((low + high) / 2))]
    step = (high - low) / (most - 1)
    return sorted({float(round(low + i * step)) for i in range(most)})
