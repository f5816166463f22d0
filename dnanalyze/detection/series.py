"""The paper's method: suppression of high frequencies over temperature.

R = power above .45 over power from .03 to .12 cycles/pixel. Of an unfiltered sensor it is 1 at
every temperature;
linear crosstalk lets it fall and level off,
R_T = (s_r^2 + P_T |K|^2_HF) / (s_r^2 + P_T |K|^2_MF), P_T the power of the dark charge.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import optimize

from dnanalyze.detection.correlation import crosstalk_kernel
from dnanalyze.detection.spectrum import OctaveSpectrum, kernel_log_power


@dataclass(frozen=True)
class SuppressionSeries:
    """ln R over temperature, with the curves it is held against.

    Parameters
    ----------
    temperature_c : ndarray
        (n,), C.
    log_ratio, se : ndarray
        (n,), ln R measured and its standard error.
    unfiltered : float
        The constant that fits best.
    crosstalk : ndarray
        (n,), ln R of the crosstalk curve that fits best.
    phi : float
        Its share to each of 8 neighbours.
    chi2_unfiltered, chi2_crosstalk : float
        Of the two fits; n - 1 and n - 2 degrees of freedom.
    """

    temperature_c: np.ndarray
    log_ratio: np.ndarray
    se: np.ndarray
    unfiltered: float
    crosstalk: np.ndarray
    phi: float
    chi2_unfiltered: float
    chi2_crosstalk: float


def crosstalk_curve(power: np.ndarray, phi: float) -> np.ndarray:
    """ln R for total powers (any unit), of which the smallest is read noise alone."""
    octaves = np.exp(kernel_log_power(crosstalk_kernel(phi), (128, 128)))
    spectrum = OctaveSpectrum(np.log(octaves), np.ones(octaves.size))
    high = float(np.exp(spectrum.suppression[0]))  # |K|^2 is 1 in the middle band
    charge = 1 - power.min() / np.maximum(power, 1e-12)
    return np.log((1 - charge) + charge * high)


def suppression_series(
    temperature_c: list[float], spectra: list[OctaveSpectrum]
) -> SuppressionSeries | None:
    """Fit both curves; None for fewer than 3 temperatures."""
    order = np.argsort(temperature_c, kind="stable")
    if len(order) < 3:
        return None
    values = np.array([spectra[i].suppression for i in order])
    good = np.isfinite(values).all(axis=1)
    if good.sum() < 3:
        return None
    y, se = values[good].T
    power = np.exp([spectra[i].log_power[4] for i in order])[good]
    weights = 1 / se**2
    constant = float(np.sum(weights * y) / weights.sum())

    def misfit(phi: float) -> float:
        return float(np.sum(weights * (y - crosstalk_curve(power, phi)) ** 2))

    best = optimize.minimize_scalar(
        misfit, bounds=(0.0, 0.06), method="bounded", options={"xatol": 1e-4}
    )
    return SuppressionSeries(
        np.asarray(temperature_c, float)[order][good], y, se, constant,
        crosstalk_curve(power, float(best.x)), float(best.x),
        float(np.sum(weights * (y - constant) ** 2)), float(best.fun),
    )  # fmt: skip
