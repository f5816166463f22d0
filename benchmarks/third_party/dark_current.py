"""Dark current over temperature, as the simulators in plain NumPy have it."""

from __future__ import annotations

import numpy as np

BOLTZMANN_EV = 8.617333e-5


def dark_growth(celsius: float, reference_c: float, gap_ev: float) -> float:
    """Dark current at a temperature over that at another: T^1.5 exp(-Eg/2kT)."""
    kelvin, reference = celsius + 273.15, reference_c + 273.15
    energy = gap_ev / (2.0 * BOLTZMANN_EV)
    return (kelvin / reference) ** 1.5 * float(np.exp(energy * (1 / reference - 1 / kelvin)))
