"""Gain that differs from column to column."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dnanalyze.model.clues import Clues
from dnanalyze.model.effect import Effect, Placing, Site, Stage, parameter
from dnanalyze.model.evidence import LINE_BANDS, band_excess, bounded, mean_power, named, shows


@dataclass(frozen=True)
class ColumnGain(Effect):
    """y -> y (1 + g_j) on the signal above black, the same in every frame."""

    name: ClassVar[str] = "column_gain"
    stage: ClassVar[Stage] = Stage.LINE_READ
    varies: ClassVar[str] = "fixed"
    placing: ClassVar[Placing] = Placing.ANYWHERE
    summary: ClassVar[str] = (
        "Vertical stripes that grow with the signal: column amplifiers differ in gain."
    )
    physics: ClassVar[str] = (
        "The capacitor ratios and ramp slopes of column amplifiers and converters differ by parts "
        "per thousand. In a dark frame the signal is the dark current, so the stripes are nearly "
        "absent when cold or short and grow in proportion to the dark signal, with its temperature "
        "and exposure law. Cure: a flat-field correction by column; an offset correction alone "
        "does not help."
    )
    formula: ClassVar[str] = "y_ij -> y_ij (1 + g_j);  g_j ~ N(0, sigma^2), once for the sensor"
    references: ClassVar[tuple[str, ...]] = (
        "El Gamal, Fowler, Min, Liu, Modeling and estimation of FPN components in CMOS image "
        "sensors, SPIE 3301 (1998)",
        "EMVA 1288 release 4.0 (PRNU1288.col)",
    )
    fingerprint: ClassVar[tuple[str, ...]] = named("pattern_columns", reversed(LINE_BANDS))
    confused_with: ClassVar[dict[str, str]] = {
        "column_fpn": "stripes of the same strength at every temperature and exposure",
        "dark_gradient": "also grows with the signal, but is smooth: power below .02 cycles/pixel",
    }

    sigma: float = parameter(2e-3, "1", 1e-6, 0.5, "standard deviation of the relative gain")

    def apply(self, signal: np.ndarray, site: Site) -> np.ndarray:
        """Multiply every column."""
        gain = site.columns(site.silicon.child("columns"))
        signal *= 1 + np.float32(self.value("sigma", site.point)) * gain
        return signal

    @classmethod
    def guess(cls, clues: Clues) -> list[Effect]:
        """Sigma from column power that grows with the mean level; needs unlike levels."""
        if not shows(clues, cls.fingerprint):
            return []
        level = np.asarray(clues.measured("mean"), float)
        variance = mean_power(band_excess(clues, "pattern_columns")) / clues.shape[0]
        known = np.isfinite(level) & np.isfinite(variance)
        if known.sum() < 2 or np.ptp(level[known]) <= 0:
            return []
        signal2 = (level[known] - level[known].min()) ** 2
        flat, slope = np.linalg.lstsq(
            np.stack([np.ones_like(signal2), signal2], axis=1), variance[known], rcond=None
        )[0]
        if slope * signal2.max() <= max(flat, 0.0):
            return []
        return [cls(bounded(cls, "sigma", math.sqrt(slope)))]
