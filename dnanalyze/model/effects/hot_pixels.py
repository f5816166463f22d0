"""A population of pixels with far more dark current than the rest."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import asdict, dataclass, replace
from typing import ClassVar

import numpy as np

from dnanalyze.loaders.captures import OperatingPoint
from dnanalyze.model.bounds import clip
from dnanalyze.model.effect import Effect, Placing, Site, Stage, choice, parameter
from dnanalyze.model.hot_signal import HotSignal
from dnanalyze.model.hot_tail import HEAVY, HotTail, amplitude
from dnanalyze.model.laws import scaled


@dataclass(frozen=True)
class HotPixels(HotTail):
    """A fraction p of the pixels has an extra dark signal: exponential, a power law, or alike."""

    name: ClassVar[str] = "hot_pixels"
    stage: ClassVar[Stage] = Stage.CHARGE
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = "few pixels with much extra dark current, the same ones in every frame"
    physics: ClassVar[str] = (
        "Single defects in the silicon (contamination, displacement damage, a high field at a "
        "junction edge) give a pixel many times the usual dark current. The same pixels "
        "stand out in every frame, above the log-normal distribution of the rest, and their "
        "signal grows in proportion to exposure. A high field lowers the barrier, so their "
        "activation energy is often below that of the bulk (0.3 to 0.6 eV against 0.6 to 1.2 "
        "eV): they stand out more when cold. The currents then range over decades, and the "
        "tail is a power law, not an exponential (`tail`), with radiation damage above a "
        "minimum (`law`: power). Defects of one kind, such as one metal atom each, are nearly "
        "alike (`law`: narrow). Remedies: cooling, dark-frame subtraction, a defect map; "
        "their number grows with radiation dose."
    )
    formula: ClassVar[str] = (
        "h += t/t_ref e^(-Ea/k (1/T - 1/T_ref)) nu max(0, ln(p/u)), u ~ U(0,1) fixed: Exp(nu) "
        "with probability p; with a tail s > 0 ((p/u)^s - 1) / s for ln(p/u): a generalised Pareto "
        "law; law power: nu (p/u)^s where u < p, Pareto from nu on; law narrow: nu (1 + w n), n "
        "normal, where u < p"
    )
    references: ClassVar[tuple[str, ...]] = (
        "Widenhorn et al. and Dunlap et al. (activation energies of hot pixels)",
        "Belloir et al., IEEE TED (2017) (radiation damage)",
        "Pickands, Ann. Statist. 3, 119 (1975) (what lies above a high threshold is Pareto)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = (
        "hot_count_16",
        "hot_count_8",
        "hot_count_32",
        "hot_count_64",
        "pattern_q0.999",
        "pattern_q0.9999",
        "hot_count_5",
        "hot_repeat",
        "pattern_noise",
    )
    confused_with: ClassVar[dict[str, str]] = {
        "convolved_lognormal": (
            "a log-normal tail bends on a semilog plot; an exponential population is straight"
        ),
        "hot_clusters": "clustered defects have hot neighbours more often than chance (hot_pairs)",
        "cosmic_rays": "a hit is in one frame only",
        "rts": "an RTS pixel has two levels over time",
        "stuck_pixels": "a stuck pixel has no temporal noise",
    }

    fraction: float = parameter(1e-3, "1", 1e-7, 0.3, "fraction of pixels that are hot")
    scale: float = parameter(
        50.0, "DN", 1e-2, 1e6, "mean extra signal at the reference temperature, exposure and gain"
    )
    ea_ev: float = parameter(
        0.55, "eV", 0.0, 1.6, "activation energy of the extra signal", "linear"
    )

    tail: float = parameter(
        0.0, "1", 0.0, 1.5, "exponent s of a power-law tail; 0 for an exponential", "linear"
    )
    law: str = choice("exponential", "distribution of the signal", "exponential", "power", "narrow")
    width: float = parameter(
        0.1, "1", 1e-3, 0.5, "standard deviation w of a narrow peak over its mean"
    )

    def inactive_parameters(self) -> tuple[str, ...]:
        """The numbers of the other laws."""
        if self.law == "narrow":
            return ("tail",)
        return ("width",) if self.law == "power" else (*super().inactive_parameters(), "width")

    def relatives(self) -> list[Effect]:
        """The heavy tail, and the power law, that have as much at a tenth of the pixels."""
        if self.law != "exponential" or self.tail != 0.0:
            return []
        s = 2.0 * HEAVY  # rates of a density r^-2, alike in every decade
        least = scaled(self.scale, math.log(10.0) / 10.0**s)
        return [*super().relatives(), replace(self, law="power", tail=s, scale=least)]  # type: ignore[arg-type]

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Add the hot pixels."""
        signal += site.keep("map", lambda: self._map(site))
        return signal

    def _map(self, site: Site) -> np.ndarray:
        share = np.float32(self.value("fraction", site.point)) / site.fixed_uniform()
        if self.law != "exponential":
            return np.float32(self.scale_at(site)) * np.where(share > 1, self._rate(share, site), 0)
        hot = amplitude(np.maximum(share, np.float32(1)), self.value("tail", site.point))
        return np.float32(self.scale_at(site)) * hot

    def _rate(self, share: np.ndarray, site: Site) -> np.ndarray:
        """Signal of a hot pixel over the scale, float32; ``share`` as for `amplitude`."""
        if self.law == "power":
            log = np.log(np.maximum(share, np.float32(1)))
            return np.asarray(np.exp(np.float32(self.value("tail", site.point)) * log))
        spread = np.float32(self.value("width", site.point)) * site.fixed_normal("peak")
        return np.asarray(np.maximum(np.float32(1) + spread, np.float32(0)))

    @classmethod
    def odds(cls, others: Collection[str]) -> float:
        """Hot pixels are what corrections are made for."""
        return 10.0 if "dpc" in others else 1.0

    def variance(self, point: OperatingPoint) -> float | None:
        """nu^2 (2 p / ((1 - s) (1 - 2 s)) - (p / (1 - s))^2), DN^2, at the reference temperature,
        exposure and gain; none from s = 1/2 on. nu^2 (p / (1 - 2 s) - (p / (1 - s))^2) of a power
        law, nu^2 (p (1 + w^2) - p^2) of a narrow peak.
        """
        p, s = self.value("fraction", point), self.value("tail", point)
        if self.law == "narrow":
            w = self.value("width", point)
            return self.value("scale", point) ** 2 * (p * (1 + w * w) - p * p)
        if s >= 0.5:
            return None
        mean = p / (1 - s)
        if self.law == "power":
            return self.value("scale", point) ** 2 * (p / (1 - 2 * s) - mean**2)
        return self.value("scale", point) ** 2 * (2 * mean / (1 - 2 * s) - mean**2)

    @classmethod
    def of_hot_signal(cls, hot: HotSignal) -> list[Effect]:
        """An exponential population."""
        return [cls(**clip(cls, **asdict(hot)))]  # type: ignore[arg-type]
