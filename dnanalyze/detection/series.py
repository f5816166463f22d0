"""The paper's method: suppression of high frequencies over temperature.

R = power above .45 over power from .03 to .12 cycles/pixel. Of an unfiltered sensor it is 1 at
every temperature;
linear crosstalk lets it fall and level off,
R_T = (s_r^2 + P_T |K|^2_HF) / (s_r^2 + P_T |K|^2_MF), P_T the power of the dark charge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy import optimize

from dnanalyze.detection.correlation import LARGEST_CROSSTALK, crosstalk_kernel
from dnanalyze.detection.spectrum import IN_MIDDLE, OctaveSpectrum, octave_log_power

if TYPE_CHECKING:
    from dnanalyze.detection.evidence import ViewEvidence


@dataclass(frozen=True)
class SuppressionSeries:
    """ln R over temperature, with the curves it is held against."""

    temperature_c: np.ndarray  # (n,), C
    # (n,), ln R measured and its standard error.
    log_ratio: np.ndarray
    se: np.ndarray
    unfiltered: float  # the constant that fits best
    crosstalk: np.ndarray  # (n,), ln R of the crosstalk curve that fits best
    phi: float  # its share to each of 8 neighbours
    # Of the two fits; n - 1 and n - 2 degrees of freedom.
    chi2_unfiltered: float
    chi2_crosstalk: float


def suppression_series(evidence: Sequence[ViewEvidence]) -> SuppressionSeries | None:
    """Fit both curves to the settings like the first, one for each temperature.

    None for fewer than 3 temperatures with a known suppression.
    """
    seen = [
        e for e in evidence if e.view == "frame" and e.usable and e.point.temperature_c is not None
    ]
    settings = [replace(e.point, temperature_c=None) for e in seen]
    like = {
        e.point.temperature_c: (*e.spectrum.suppression, e.spectrum.log_power[IN_MIDDLE])
        for e, here in zip(seen, settings, strict=True)
        if here == settings[0]
    }
    known = [(celsius, *of) for celsius, of in sorted(like.items()) if np.isfinite(of[:2]).all()]
    if len(known) < 3:
        return None
    celsius, ratio, se, log_power = np.array(known, float).T
    weights = 1 / se**2
    constant = float(np.sum(weights * ratio) / weights.sum())

    def chi2(curve: np.ndarray | float) -> float:
        return float(np.sum(weights * (ratio - curve) ** 2))

    best = optimize.minimize_scalar(
        lambda phi: chi2(crosstalk_curve(np.exp(log_power), phi)),
        bounds=(0.0, 3 * LARGEST_CROSSTALK),
        method="bounded",
        options={"xatol": 1e-4},
    )
    phi = float(best.x)
    crosstalk = crosstalk_curve(np.exp(log_power), phi)
    return SuppressionSeries(
        celsius, ratio, se, constant, crosstalk, phi, chi2(constant), chi2(crosstalk)
    )


def crosstalk_curve(power: np.ndarray, phi: float) -> np.ndarray:
    """ln R for total powers (any unit), of which the smallest is read noise alone."""
    octaves = 2 * octave_log_power(crosstalk_kernel(phi), (128, 128))
    spectrum = OctaveSpectrum(octaves, np.ones(octaves.size))
    high = float(np.exp(spectrum.suppression[0]))  # |K|^2 is 1 in the middle band
    charge = 1 - power.min() / np.maximum(power, 1e-12)
    return np.log((1 - charge) + charge * high)
