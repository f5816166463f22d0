"""How an unexplained amplitude goes with temperature, exposure and gain, for first guesses."""

from __future__ import annotations

import numpy as np

from dnanalyze.loaders.thermometer import tells_slope
from dnanalyze.model.clues import Clues
from dnanalyze.thermal import KELVIN, activation, arrhenius, arrhenius_line


def unexplained_sigma(clues: Clues, name: str) -> float | None:
    """Standard deviation at the reference gain that the model lacks, DN; None: not measured.

    The median over the settings where it lacks any; where it lacks none, most of the least of all.
    """
    measured, simulated = (of(name) for of in (clues.measured, clues.simulated))
    lost = (measured**2 - simulated**2) / gains(clues) ** 2
    good = lost[np.isfinite(lost) & (lost > 0)]
    if good.size:
        return float(np.sqrt(np.median(good)))
    total = measured / gains(clues)
    return 0.7 * float(np.nanmin(total)) if np.isfinite(total).any() else None


def exposure_and_gain(clues: Clues) -> np.ndarray:
    """Exposure times gain over the reference's, one a setting; 1 where unknown, NaN where 0."""
    ratios = []
    for point in clues.points:
        ratio = 1.0
        for here, there in (
            (point.exposure_s, clues.reference.exposure_s),
            (point.gain, clues.reference.gain),
        ):
            if here is not None and there:
                ratio *= here / there
        ratios.append(ratio or np.nan)
    return np.array(ratios)


def gains(clues: Clues) -> np.ndarray:
    """Gain over the reference's, one a setting; 1 where unknown."""
    return np.array([p.gain_over(clues.reference) for p in clues.points])


def photon_transfer(clues: Clues) -> tuple[np.ndarray, np.ndarray]:
    """Mean level and temporal variance at the reference gain, DN and DN^2, one a setting.

    Less what moves whole frames.
    """
    mean = clues.measured("mean") / gains(clues)
    return mean, clues.measured("s2_temporal") / gains(clues) ** 2


def thermal_growth(clues: Clues, ea_ev: np.ndarray) -> np.ndarray:
    """Growth from the reference temperature by Arrhenius, (energies, settings); 1 where unknown."""
    origin = clues.reference.temperature_c
    known = [origin if p.temperature_c is None else p.temperature_c for p in clues.points]
    if origin is None:
        return np.ones((len(ea_ev), len(known)))
    return np.array([[arrhenius(t, origin, float(e)) for t in known] for e in ea_ev])


def thermal_fit(
    clues: Clues, amplitude: np.ndarray, default_ev: float = 0.6
) -> tuple[float, float] | None:
    """Amplitude at the reference and activation energy from one amplitude a setting.

    The amplitudes are already over exposure and gain; settings without a positive finite one are
    left out, and the larger ones weigh more, for they stand farther above their noise. Returns the
    amplitude at the reference temperature and an energy of 0 to 1.5 eV, ``default_ev`` where the
    settings cannot tell it; None without any usable setting.
    """
    good = np.isfinite(amplitude) & (amplitude > 0)
    if not good.any():
        return None
    temperature = [p.temperature_c for p in clues.points]
    origin = clues.reference.temperature_c
    if origin is None or any(t is None for t, g in zip(temperature, good, strict=True) if g):
        return float(np.median(amplitude[good])), default_ev
    celsius = np.array([origin if t is None else t for t in temperature])[good]
    x, y = activation(celsius + KELVIN, origin + KELVIN), np.log(amplitude[good])
    w = np.exp(0.5 * (y - y.max()))
    determined = tells_slope(t for t, g in zip(temperature, good, strict=True) if g)
    ea = (
        arrhenius_line(x, amplitude[good], 1.0 / np.sqrt(w)).energy_ev if determined else default_ev
    )
    ea = min(max(ea, 0.0), 1.5)
    return float(np.exp(np.average(y - ea * x, weights=w))), ea
