"""Extra dark signal of few pixels, in numbers that all effects of that kind have."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class HotSignal:
    """What is told of hot pixels before it is known of which kind they are.

    Parameters
    ----------
    fraction : float
        Of the pixels.
    scale : float
        Mean extra signal of one at the reference temperature, exposure and gain, DN.
    ea_ev : float
        Activation energy, eV.
    """

    fraction: float
    scale: float
    ea_ev: float
