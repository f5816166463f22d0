"""Quantised dark current: pixels with one, two, three of the same metal atom."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import pdtrc

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model import hints
from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Site, Stage, parameter
from dnanalyze.model.evidence import SIGN, shows


@dataclass(frozen=True)
class DarkCurrentSteps(Effect):
    """h += n q, n ~ Pois(lambda) fixed: equally spaced peaks in the histogram."""

    name: ClassVar[str] = "dark_current_steps"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
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
        step = self.value("step", site.point) * site.thermal(self.value("ea_ev", site.point))
        step *= site.exposure_ratio * site.gain_ratio
        # u is the probability of a larger number: it is finest near 0, where the tail is
        tail = pdtrc(np.arange(int(lam + 12 * np.sqrt(lam) + 24)), lam).astype(np.float32)
        number = tail.size - np.searchsorted(tail[::-1], site.fixed_uniform(), side="right")
        return np.float32(step) * number.astype(np.float32)

    def variance(self, point: OperatingPoint) -> float:
        """lambda q^2, DN^2, at the reference temperature, exposure and gain."""
        return self.value("mean_number", point) * self.value("step", point) ** 2

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """The spacing of the peaks, setting by setting; few or many atoms a pixel."""
        if not shows(clues, ("pattern_steps",)):
            return []
        z = np.nan_to_num(clues.z("pattern_steps"))
        spacing = np.asarray(clues.measured("pattern_step_dn"), float)
        spacing = np.where(z > SIGN, spacing, np.nan)
        fitted = hints.thermal_fit(clues, spacing / hints.exposure_and_gain(clues), 0.35)
        if fitted is None:
            return []
        step, ea = fitted
        return [
            cls(**hints.clip(cls, step=step, mean_number=number, ea_ev=ea))
            for number in (0.1, 0.5, 2.0)
        ]
