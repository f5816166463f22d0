"""Quantised dark current: pixels with one, two, three of the same metal atom."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import pdtrc

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.bounds import clip
from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter
from dnanalyze.model.hot_signal import HotSignal
from dnanalyze.thermal import arrhenius

# Pixels with two atoms from which there are steps: of 100 sensors with 5 in the mean, 99 show one
SECOND_PEAK = 5.0


@dataclass(frozen=True)
class DarkCurrentSteps(Effect):
    """h += (n + 2 m) q, n and m Poisson and fixed: equally spaced peaks in the histogram."""

    name: ClassVar[str] = "dark_current_steps"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "equally spaced peaks in the dark current: counted impurity atoms"
    physics: ClassVar[str] = (
        "Each atom of a metal that contaminates the silicon generates the same dark current, so a "
        "pixel's dark current rises by a whole number of equal steps and the histogram of the "
        "pattern has equally spaced peaks. The spacing grows with exposure and, with the "
        "activation energy of the trap (about 0.3 eV for molybdenum, 0.37 eV for tungsten), with "
        "temperature; the shares of the peaks do not change. Where atoms come in pairs, the second "
        "peak is higher than chance has it (`pairs`). The spacing identifies the metal and "
        "its concentration: a matter for the wafer process. Cooling and dark subtraction help."
    )
    formula: ClassVar[str] = (
        "h += (n + 2 m) q t/t_ref e^(-Ea/k (1/T - 1/T_ref)), n ~ Pois(lambda (1 - p)) and "
        "m ~ Pois(lambda p) fixed; variance lambda (1 + 3 p) q^2"
    )
    references: ClassVar[tuple[str, ...]] = (
        "McColgin et al., IEDM (1992) (dark current quantisation in image sensors)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "pattern_steps",
        "pattern_q0.99",
        "pattern_q0.999",
        "pattern_q0.9",
        "pattern_noise",
        "hot_count_5",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "digital_gain": "a comb of codes keeps its spacing in DN at every temperature and exposure",
        "missing_codes": (
            "unequal codes stand at fixed values, steps move with temperature and exposure"
        ),
        "hot_pixels": (
            "hot pixels have no preferred amplitude, or a single one: there is no second peak"
        ),
    }

    step: float = parameter(
        10.0, "DN", 1e-2, 1e5, "signal of one atom at the reference temperature, exposure and gain"
    )
    mean_number: float = parameter(0.2, "1", 1e-5, 20.0, "mean number of centres in a pixel")
    ea_ev: float = parameter(0.35, "eV", 0.0, 1.6, "activation energy of the trap", "linear")
    pairs: float = parameter(0.0, "1", 0.0, 1.0, "share of the centres with two atoms", "linear")

    def inactive_parameters(self) -> tuple[str, ...]:
        """The share of pairs where there are none."""
        return ("pairs",) if self.pairs == 0.0 else ()

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the steps."""
        signal += site.keep("map", lambda: self._map(site))
        return signal

    def _map(self, site: Site) -> np.ndarray:
        number, pairs = (self.value(name, site.point) for name in ("mean_number", "pairs"))
        atoms = _counts(number * (1.0 - pairs), site.fixed_uniform())
        if pairs > 0.0:
            atoms += 2.0 * _counts(number * pairs, site.fixed_uniform("pairs"))
        return np.float32(self._step_at(site.point, site.reference)) * atoms

    def shows_in(self, frames: int, pixels: int) -> bool:
        """Not where hardly a pixel holds two atoms: one peak is that of alike hot pixels."""
        number, pairs = self.mean_number, self.pairs
        if not (isinstance(number, (int, float)) and isinstance(pairs, (int, float))):
            return True
        return pixels * ((number * (1.0 - pairs)) ** 2 / 2.0 + number * pairs) >= SECOND_PEAK

    @classmethod
    def odds(cls, others: Collection[str]) -> float:
        """Few sensors are contaminated, nearly all have hot pixels."""
        return 0.1

    def variance(self, point: OperatingPoint) -> float:
        """lambda (1 + 3 p) q^2, DN^2, at the reference temperature, exposure and gain."""
        number = self.value("mean_number", point) * (1.0 + 3.0 * self.value("pairs", point))
        return number * self.value("step", point) ** 2

    def adds(
        self, point: OperatingPoint, reference: OperatingPoint, shape: tuple[int, int]
    ) -> tuple[float, float]:
        """lambda (1 + p) q and lambda (1 + 3 p) q^2."""
        number, step = self.value("mean_number", point), self._step_at(point, reference)
        pairs = self.value("pairs", point)
        return number * (1.0 + pairs) * step, number * (1.0 + 3.0 * pairs) * step**2

    def _step_at(self, point: OperatingPoint, reference: OperatingPoint) -> float:
        """Signal of one atom, DN."""
        energy = self.value("ea_ev", point)
        growth = arrhenius(point.temperature_c, reference.temperature_c, energy)
        step = self.value("step", point) * growth
        return step * (point.exposure_over(reference) * point.gain_over(reference))

    @classmethod
    def of_hot_signal(cls, hot: HotSignal) -> list[Effect]:
        """Each hot pixel with one atom, and few with more."""
        number = -math.log1p(-min(hot.fraction, 0.5))
        step = hot.scale * hot.fraction / number
        return [cls(**clip(cls, step=step, mean_number=number, ea_ev=hot.ea_ev))]


def _counts(mean: float, u: np.ndarray) -> np.ndarray:
    """Poisson numbers from uniform deviates, float32.

    u is the probability of a larger number: it is finest near 0, where the tail is.
    """
    tail = pdtrc(np.arange(int(mean + 12 * np.sqrt(mean) + 24)), mean).astype(np.float32)
    return (tail.size - np.searchsorted(tail[::-1], u, side="right")).astype(np.float32)
