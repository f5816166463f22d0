"""Quantised dark current: pixels with one, two, three of the same metal atom."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import pdtrc

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model import hints
from dnanalyze.model.clues import Clues
from dnanalyze.model.counted_steps import counted_steps
from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter
from dnanalyze.model.evidence import SIGN, curve, shows
from dnanalyze.model.hot_signal import HotSignal
from dnanalyze.model.laws import arrhenius

FAR = 5.0  # robust standard deviations of the pattern from which a pixel counts as hot
FEWEST = 20  # hot pixels that show how they are spread
NARROW = 0.4  # quartile distance over median; 1.6 where amplitudes are exponential


@dataclass(frozen=True)
class DarkCurrentSteps(Effect):
    """h += n q, n ~ Pois(lambda) fixed: equally spaced peaks in the histogram."""

    name: ClassVar[str] = "dark_current_steps"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.EVERYWHERE
    summary: ClassVar[str] = "equally spaced peaks in the dark current: counted impurity atoms"
    physics: ClassVar[str] = (
        "Each atom of a metal that contaminates the silicon generates the same dark current, so "
        "a pixel's dark current rises by a whole number of equal steps and the histogram of the "
        "pattern has equally spaced peaks. The spacing grows with exposure and, with the "
        "activation energy of the trap (about .3 eV for molybdenum, .37 eV for tungsten), with "
        "temperature; the shares of the peaks do not move. That tells the metal and its "
        "concentration: a matter for the wafer process. Cooling and dark subtraction help."
    )
    formula: ClassVar[str] = (
        "h += n q t/t_ref e^(-Ea/k (1/T - 1/T_ref)), n ~ Pois(lambda) fixed; variance lambda q^2"
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
        "hot_pixels": "hot pixels have no preferred amplitude",
    }

    step: float = parameter(
        10.0, "DN", 1e-2, 1e5, "signal of one atom at the reference temperature, exposure and gain"
    )
    mean_number: float = parameter(0.2, "1", 1e-5, 20.0, "mean number of atoms in a pixel")
    ea_ev: float = parameter(0.35, "eV", 0.0, 1.6, "activation energy of the trap", "linear")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the steps."""
        signal += site.keep("map", lambda: self._map(site))
        return signal

    def _map(self, site: Site) -> np.ndarray:
        lam = self.value("mean_number", site.point)
        step = self._step_at(site.point, site.reference)
        # u is the probability of a larger number: it is finest near 0, where the tail is
        tail = pdtrc(np.arange(int(lam + 12 * np.sqrt(lam) + 24)), lam).astype(np.float32)
        number = tail.size - np.searchsorted(tail[::-1], site.fixed_uniform(), side="right")
        return np.float32(step) * number.astype(np.float32)

    @classmethod
    def odds(cls, others: Collection[str]) -> float:
        """Few sensors are contaminated, nearly all have hot pixels."""
        return 0.1

    def variance(self, point: OperatingPoint) -> float:
        """lambda q^2, DN^2, at the reference temperature, exposure and gain."""
        return self.value("mean_number", point) * self.value("step", point) ** 2

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """The spacing of the peaks, setting by setting; few or many atoms a pixel."""
        found = _counted(cls, clues)
        rare = _single_peak(clues)
        if rare is not None:
            found += _grown(cls, clues, rare[0], [rare[1]])
        if shows(clues, ("pattern_steps",)):
            z = np.nan_to_num(clues.z("pattern_steps"))
            spacing = np.asarray(clues.measured("pattern_step_dn"), float)
            found += _grown(cls, clues, np.where(z > SIGN, spacing, np.nan), [0.1, 0.5, 2.0])
        return found

    def adds(self, point: OperatingPoint, reference: OperatingPoint) -> tuple[float, float]:
        """lambda q and lambda q^2."""
        number, step = self.value("mean_number", point), self._step_at(point, reference)
        return number * step, number * step**2

    def _step_at(self, point: OperatingPoint, reference: OperatingPoint) -> float:
        """Signal of one atom, DN."""
        step, origin = self.value("step", point), reference.temperature_c
        if origin is not None:
            step *= arrhenius(point.temperature_c, origin, self.value("ea_ev", point))
        return step * (point.exposure_over(reference) * point.gain_over(reference))

    def hot_signal(self, reference: OperatingPoint) -> HotSignal:
        """Of the pixels with an atom or more."""
        number, ea_ev = self.value("mean_number", reference), self.value("ea_ev", reference)
        fraction = -math.expm1(-number)
        return HotSignal(fraction, self.value("step", reference) * number / fraction, ea_ev)

    @classmethod
    def of_hot_signal(cls, found: HotSignal) -> list[Effect]:
        """Each hot pixel with one atom, and few with more."""
        number = -math.log1p(-min(found.fraction, 0.5))
        step = found.scale * found.fraction / number
        return [cls(**hints.clip(cls, step=step, mean_number=number, ea_ev=found.ea_ev))]


def _counted(cls: type[DarkCurrentSteps], clues: Clues) -> list[Effect]:
    """Of the ripples in the characteristic functions of all settings."""
    if not shows(clues, cls.fingerprint):
        return []
    spacing, numbers = np.full(len(clues.points), np.nan), []
    for setting in range(spacing.size):
        x, n = (curve(clues, f"pattern_hist_{axis}", setting) for axis in "xn")
        found = None if x is None or n is None else counted_steps(x, n)
        if found is not None:
            spacing[setting] = found[0]
            numbers.append(found[1])
    return _grown(cls, clues, spacing, [float(np.median(numbers))]) if numbers else []


def _grown(
    cls: type[DarkCurrentSteps], clues: Clues, spacing: np.ndarray, numbers: list[float]
) -> list[Effect]:
    """Guesses from a spacing of peaks, DN, one a setting."""
    fitted = hints.thermal_fit(clues, spacing / hints.exposure_and_gain(clues), 0.35)
    if fitted is None:
        return []
    step, ea = fitted
    return [cls(**hints.clip(cls, step=step, mean_number=n, ea_ev=ea)) for n in numbers]


def _single_peak(clues: Clues) -> tuple[np.ndarray, float] | None:
    """Amplitude, DN, one a setting, and share of hot pixels that are all about equally hot.

    Where atoms are rare nearly all such pixels hold one: a single peak far above the core, and no
    spacing to be seen. Hot pixels of other origin spread over a decade.
    """
    if not shows(clues, [f"hot_count_{k}" for k in (5, 8, 16)]):
        return None
    sigma = np.asarray(clues.measured("pattern_noise_core"), float)
    amplitude, shares = np.full(sigma.size, np.nan), []
    for setting in range(sigma.size):
        x, n = (curve(clues, f"pattern_hist_{axis}", setting) for axis in "xn")
        if x is None or n is None or not np.isfinite(sigma[setting]):
            continue
        summed = np.cumsum(n)
        x = x - np.interp(0.5 * summed[-1], summed, x)
        hot = x > FAR * sigma[setting]
        count = np.cumsum(n[hot])
        if not hot.any() or count[-1] < FEWEST:
            continue
        low, middle, high = np.interp(np.array([0.25, 0.5, 0.75]) * count[-1], count, x[hot])
        if high - low < NARROW * middle:
            amplitude[setting] = middle
            shares.append(float(count[-1] / summed[-1]))
    return (amplitude, max(shares)) if shares else None
