"""Thermally activated quantities: the Arrhenius law and the one fit of it.

A rate grows as exp(E x) with x = (1/Tref - 1/T)/k, so that its logarithm is a line in x. Sums of
such a law and a constant are linear in everything but the energy E: that is found by the least
chi square, each time with the best linear coefficients (variable projection, Golub and Pereyra,
SIAM Journal on Numerical Analysis 10, 1973).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

BOLTZMANN_EV = 8.617333e-5  # eV/K
KELVIN = 273.15  # of 0 C
OVERFLOW = 700.0  # exponent of the largest double


def arrhenius(temperature_c: float | None, reference_c: float | None, ea_ev: float) -> float:
    """Growth factor exp(-Ea/k (1/T - 1/Tref)) of a thermally activated rate.

    Parameters
    ----------
    temperature_c : float or None
        C; unknown gives 1.
    reference_c : float or None
        C, where the factor is 1; unknown gives 1.
    ea_ev : float
        Activation energy, eV.
    """
    if temperature_c is None or reference_c is None:
        return 1.0
    inverse = 1.0 / (temperature_c + KELVIN) - 1.0 / (reference_c + KELVIN)
    return math.exp(min(OVERFLOW, -ea_ev / BOLTZMANN_EV * inverse))


def activation(kelvin: np.ndarray | float, reference: float) -> np.ndarray:
    """x = (1/Tref - 1/T)/k, 1/eV: a rate of energy E grows as exp(E x).

    Parameters
    ----------
    kelvin : ndarray or float
        Temperature, K.
    reference : float
        Temperature of growth 1, K.
    """
    return np.asarray((1.0 / reference - 1.0 / np.asarray(kelvin, float)) / BOLTZMANN_EV)


@dataclass(frozen=True)
class ArrheniusLine:
    """Logarithm of a rate as a line in x.

    Parameters
    ----------
    log_rate, energy_ev : float
        At x = 0; slope, eV.
    variance : float
        Of the energy by the stated errors, eV^2.
    pulls : ndarray
        Residuals in stated errors.
    """

    log_rate: float
    energy_ev: float
    variance: float
    pulls: np.ndarray


def arrhenius_line(x: np.ndarray, rate: np.ndarray, relative: np.ndarray) -> ArrheniusLine:
    """Weighted least squares of log(rate) over x.

    Parameters
    ----------
    x : ndarray
        From `activation`, 1/eV; two different values at least.
    rate, relative : ndarray
        Positive rates, and their relative errors.
    """
    basis = np.stack([np.ones_like(x), x], axis=1) / relative[:, None]
    inverse = np.linalg.inv(basis.T @ basis)
    y = np.log(rate) / relative
    solution = inverse @ (basis.T @ y)
    log_rate, energy = map(float, solution)
    return ArrheniusLine(log_rate, energy, float(inverse[1, 1]), y - basis @ solution)


def least_energy(chi2: Callable[[float], float], energies: np.ndarray) -> float:
    """Energy of the least chi square, eV: the best of a grid, and the minimum beside it.

    Parameters
    ----------
    chi2 : callable
        Of an energy, the linear coefficients at their best.
    energies : ndarray
        Grid in even steps, eV; its ends bound the result.
    """
    from scipy.optimize import minimize_scalar

    near = float(energies[int(np.argmin([chi2(float(e)) for e in energies]))])
    step = float(energies[1] - energies[0])
    low, high = max(near - step, float(energies[0])), min(near + step, float(energies[-1]))
    found = minimize_scalar(chi2, bounds=(low, high), method="bounded", options={"xatol": 1e-4})
    return float(found.x) if found.fun < chi2(near) else near


@dataclass(frozen=True)
class OverConstant:
    """A constant and an activated part of a series.

    Parameters
    ----------
    constant, error : float
        And its standard error by the stated errors, the energy free.
    size : float
        Of the activated part at x = 0 and unit exposure, 0 or more.
    energy_ev : float
    pulls : ndarray
        Residuals in stated errors.
    """

    constant: float
    error: float
    size: float
    energy_ev: float
    pulls: np.ndarray


def over_constant(
    x: np.ndarray,
    exposure: np.ndarray,
    level: np.ndarray,
    error: np.ndarray,
    energies: np.ndarray,
    known: tuple[float, float] | None = None,
) -> OverConstant:
    """Fit level = constant + size * exposure * exp(E x).

    Parameters
    ----------
    x : ndarray
        From `activation`, 1/eV.
    exposure, level, error : ndarray
        Of each member of the series, s, and the unit of the level.
    energies : ndarray
        Grid of energies, eV.
    known : tuple of float, optional
        The constant as recorded, and its standard error.
    """
    at, scale = float(np.max(x)), float(np.max(exposure))
    value = level if known is None else np.append(level, known[0])
    sigma = error if known is None else np.append(error, known[1])

    def columns(energy: float) -> np.ndarray:
        grown = exposure / scale * np.exp(energy * (x - at))
        grown = grown if known is None else np.append(grown, 0.0)
        return np.stack([np.ones_like(grown), grown], axis=1) / sigma[:, None]

    def solved(energy: float) -> tuple[np.ndarray, np.ndarray]:
        basis = columns(energy)
        both = np.linalg.lstsq(basis, value / sigma, rcond=None)[0]
        if both[1] < 0.0:  # the rate of a charge is none below zero
            flat = float(np.sum(value / sigma**2) / np.sum(sigma**-2.0))
            both = np.array([flat, 0.0])
        return both, value / sigma - basis @ both

    energy = least_energy(lambda e: float(np.sum(solved(e)[1] ** 2)), energies)
    (constant, size), pulls = solved(energy)
    basis = columns(energy)
    moved = np.append(x - at, 0.0)[: len(value)] * size * basis[:, 1]  # by the energy
    jacobian = np.column_stack([basis, moved])
    variance = float(np.linalg.pinv(jacobian.T @ jacobian)[0, 0])
    size = float(size) / scale * math.exp(max(-OVERFLOW, -energy * at))
    return OverConstant(float(constant), math.sqrt(variance), size, energy, pulls)
