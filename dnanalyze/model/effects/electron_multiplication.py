"""A register that multiplies the charge on its way out: excess noise, and clock-induced charge."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter

ROUND = 8.0  # shape from which a gamma deviate follows by Wilson and Hilferty's formula


@dataclass(frozen=True)
class ElectronMultiplication(Effect):
    """n' = Pois(c) + n electrons enter, Gamma(n'/(F2 - 1)) (F2 - 1) leave, over the gain."""

    name: ClassVar[str] = "electron_multiplication"
    stage: ClassVar[Stage] = Stage.REGISTER
    varies: ClassVar[str] = "temporal"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "excess noise and clock-induced charge of an electron-multiplying CCD"
    physics: ClassVar[str] = (
        "An electron-multiplying CCD sends the charge through a register of hundreds of elements "
        "at a high voltage; in each an electron frees another one with a probability of 1 or 2 %. "
        "The gain G of the register makes read noise small beside one electron, but it is random: "
        "the variance of the charge is multiplied by the excess noise factor F2 = 2 (G - 1) "
        "G^(-(N+1)/N) + 1/G of N elements, which tends to 2. All is referred to the input of the "
        "register, so that the conversion gain K (DN per electron there) holds G already. "
        "Clocking adds few electrons to every pixel of every frame. Their number does not depend "
        "on the exposure and hardly on temperature, so that several exposures separate them from "
        "the dark charge; at a single one only the DSNU does, of which they have none. The slope "
        "of temporal variance over mean is F2 K: photon transfer takes the register for a larger "
        "conversion gain. The skewness of the temporal noise tells them apart: its third cumulant "
        "is (2 F2 - 1)/F2 times that of counting noise of the same mean and variance, 1.5 times at "
        "high gain. A register at high gain with F2 near 2 is commonly followed by counting "
        "photons, where hardly any pixel holds more than one electron."
    )
    formula: ClassVar[str] = (
        "y = (F2 - 1) K Gamma(n/(F2 - 1)), n = max(h,0)/K + Pois(c), K of dark_shot_noise; of a "
        "Poisson number of mean m: mean m, variance F2 m, third cumulant F2 (2 F2 - 1) m, in "
        "electrons; exact for F2 = 2"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Basden, Haniff, Mackay, Photon counting strategies with low-light-level CCDs, "
        "MNRAS 345 (2003)",
        "Robbins and Hadwen, The noise performance of electron multiplying charge-coupled "
        "devices, IEEE Trans. Electron Devices 50 (2003)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "temporal_skewness",
        "temporal_kurtosis",
        "temporal_q0.999",
        "temporal_q0.001",
        "frame_q0.999",
        "frame_q0.001",
        "temporal_noise",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "dark_shot_noise": "counting noise of a larger conversion gain has the same photon "
        "transfer and less skewness: its third cumulant is the variance squared over the mean",
        "read_noise": "read noise is symmetric and does not grow with the dark signal",
        "heavy_tailed_read_noise": "heavy tails are the same in cold frames, and on both sides",
        "cosmic_rays": "hits are few, and far above all else",
    }

    excess: float = parameter(
        2.0, "1", 1.01, 2.5, "excess noise factor F2: 1 without, 2 at high gain"
    )
    induced: float = parameter(
        0.01, "e-", 1e-4, 1e3, "clock-induced charge c, mean of a pixel and frame"
    )

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Multiply the charge."""
        k = 1.0 if site.dn_per_e is None else site.dn_per_e
        more = self.value("excess", site.point) - 1.0
        below = np.minimum(signal, np.float32(0))
        entering = (signal - below) * np.float32(1.0 / k)
        entering += poisson(self.value("induced", site.point), site.uniform("induced"))
        leaving = self._multiplied(entering / np.float32(more), site)
        leaving *= np.float32(more * k)
        leaving += below
        return leaving

    def _multiplied(self, shape: np.ndarray, site: Site) -> np.ndarray:
        """Gamma deviates of these shapes, one a pixel, float32.

        Of a small shape a: Gamma(a + m) times the product of U^(1/(a + i)), i from 0 to m - 1, is
        Gamma(a).
        """
        a = shape.astype(np.float64)
        few = np.flatnonzero(a < ROUND)
        large = a.copy()
        large.flat[few] += ROUND
        out = wilson_hilferty(large, site.normal("gain"))
        if few.size:
            rows, columns = np.divmod(few, a.shape[1])
            index = (site.window.top + rows) * site.shape[1] + site.window.left + columns
            small = a.flat[few]
            held = small > 0
            exponent = np.zeros(few.size)
            for i in range(int(ROUND)):
                u = site.frame_stream.child("gain", i).uniform_at(index).astype(np.float64)
                exponent += np.log(u) / np.where(held, small + i, 1.0)
            out.flat[few] *= np.where(held, np.exp(exponent), 0.0)
        return out.astype(np.float32)

    def nuisance_bias(self, name: str, unit: str, noise: float = math.inf) -> tuple[float, float]:
        """Photon transfer without it has F2 times the conversion gain."""
        if name == "dark_shot_noise.dn_per_e" and isinstance(self.excess, (int, float)):
            return 1.0 / self.excess, 0.0
        return 1.0, 0.0


def wilson_hilferty(shape: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Gamma deviates from standard normal ones, double precision.

    From shape 8 on the mean is right to 1e-6, the variance to 1e-4, the skewness to 5e-3.
    """
    ninth = 1.0 / (9.0 * shape)
    root = 1.0 - ninth + z * np.sqrt(ninth)
    result: np.ndarray = shape * np.maximum(root, 0.0) ** 3
    return result


def poisson(mean: float, u: np.ndarray) -> np.ndarray:
    """Counts of one mean from uniform deviates, float32, by inversion.

    Counts beyond 12 standard deviations and 30 more have a probability below 2^-33.
    """
    most = int(mean + 12.0 * math.sqrt(mean)) + 30
    terms = [math.exp(k * math.log(mean) - mean - math.lgamma(k + 1.0)) for k in range(most)]
    return np.searchsorted(np.cumsum(terms), u).astype(np.float32)


def excess_noise(gain: float, elements: int) -> float:
    """Excess noise factor F2 of a register (Robbins and Hadwen 2003).

    Parameters
    ----------
    gain : float
        Of the whole register.
    elements : int
        How many it has.

    Returns
    -------
    float
        1 at gain 1, towards 2 at high gain.
    """
    return 2.0 * (gain - 1.0) * gain ** (-(elements + 1.0) / elements) + 1.0 / gain
