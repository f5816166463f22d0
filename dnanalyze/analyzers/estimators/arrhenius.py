"""Thermally activated rates: one activation energy, or two populations of pixels."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from dnanalyze.analyzers.statistics import Value
from dnanalyze.thermal import BOLTZMANN_EV, ArrheniusLine, activation, arrhenius_line

BETTER = 13.8  # drop of chi^2 for two more parameters: p = .001
# Dark current of silicon: .2 to .3 eV where fields lower the barrier, half the gap (.55 to .65)
# in depletion, the gap (1.1 to 1.2) by diffusion, with room for the T^3 of its prefactor.
USUAL_EV = (0.2, 1.5)
BEYOND = 2.0  # standard errors


def misfit(pulls: np.ndarray, parameters: int) -> float:
    """By how much the scatter exceeds the stated errors, at least 1."""
    degrees = pulls.size - parameters
    return max(1.0, math.sqrt(float(pulls @ pulls) / degrees)) if degrees > 0 else 1.0


def arrhenius_laws(kelvin: np.ndarray, rate: np.ndarray, relative: np.ndarray) -> dict[str, Value]:
    """Activation energy of rates R exp(-Ea/k (1/T - 1/Tm)), or of two such populations.

    Parameters
    ----------
    kelvin, rate, relative : ndarray
        Temperatures, K; rates, DN/s, and their relative errors.

    Returns
    -------
    dict
        ``activation_energy_ev`` and ``doubling_step_c`` (k T^2 ln 2 / Ea at the middle temperature)
        of one law; and of the sum of two, where it lowers chi^2 by more than 13.8,
        ``activation_energy_1_ev``, ``activation_energy_2_ev`` and ``activation_share``.
    """
    middle = 2 / (1 / kelvin.min() + 1 / kelvin.max())
    x = activation(kelvin, float(middle))
    one = arrhenius_line(x, rate, relative)
    energy, se = one.energy_ev, math.sqrt(one.variance) * misfit(one.pulls, 2)
    out = {"activation_energy_ev": Value(energy, se)}
    if energy > 3 * se:
        step = BOLTZMANN_EV * middle**2 * math.log(2) / energy
        out["doubling_step_c"] = Value(float(step), float(step) * se / energy)
    if kelvin.size >= 6:
        out |= _two_populations(x, rate, relative, one)
    return out


def unusual(energy_ev: float, se: float) -> bool:
    """Whether an activation energy lies outside those of dark current by more than its error."""
    low, high = USUAL_EV
    return energy_ev + BEYOND * se < low or energy_ev - BEYOND * se > high


def doubts(trends: Mapping[str, Value]) -> list[str]:
    """A sentence for each activation energy that is not one of dark current."""
    energies = ((n, trends.get(f"activation_energy_{n}ev")) for n in ("", "1_", "2_"))
    step = trends.get("doubling_step_c")
    return [
        f"The activation energy of {v.value:.3g} +- {v.se:.2g} eV"
        + (f" (doubling every {step.value:.3g} C)" if step is not None and not n else "")
        + f" is not that of a dark current, {USUAL_EV[0]:g} to {USUAL_EV[1]:g} eV: check the "
        "temperatures, the exposures and the black level, and whether light fell on the sensor."
        for n, v in energies
        if v is not None and unusual(v.value, v.se)
    ]


def _two_populations(
    x: np.ndarray, rate: np.ndarray, relative: np.ndarray, one: ArrheniusLine
) -> dict[str, Value]:
    from scipy.optimize import least_squares

    def law(p: np.ndarray) -> np.ndarray:
        low, high = np.exp(p[0] + p[1] * x), np.exp(p[2] + (p[1] + p[3]) * x)
        return np.asarray(low + high)

    def pulls(p: np.ndarray) -> np.ndarray:
        return (np.log(rate) - np.log(law(p))) / relative

    half = one.log_rate - math.log(2)
    starts = [[half, max(one.energy_ev - gap / 2, 0.06), half, gap] for gap in (0.3, 0.6)]
    bounds = ([-200, 0.05, -200, 0.1], [200, 3.0, 200, 3.0])
    fits = [least_squares(pulls, start, bounds=bounds) for start in starts]
    fit = min(fits, key=lambda f: f.cost)
    scale = misfit(fit.fun, 4)
    if float(one.pulls @ one.pulls) - 2 * fit.cost < BETTER * scale**2:
        return {}
    low, energy, high, gap = fit.x
    share = 1 / (1 + math.exp(low - high))
    if not 0.02 < share < 0.98:
        return {}
    covariance = np.linalg.pinv(fit.jac.T @ fit.jac) * scale**2
    second = math.sqrt(covariance[1, 1] + covariance[3, 3] + 2 * covariance[1, 3])
    contrast = covariance[0, 0] + covariance[2, 2] - 2 * covariance[0, 2]
    return {
        "activation_energy_1_ev": Value(float(energy), math.sqrt(covariance[1, 1])),
        "activation_energy_2_ev": Value(float(energy + gap), second),
        "activation_share": Value(share, share * (1 - share) * math.sqrt(max(contrast, 0.0))),
    }
